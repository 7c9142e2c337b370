// Regions: a box [x, y, width, height] or an ellipse [x, y, a, b, theta], in pixels of the film.
// Pixel centers have integer coordinates: a box covers x - 1/2 to x + width - 1/2.

export const isBox = (region) => region.length === 4;

/** Return a region as an ellipse; a box as the upright ellipse in it. */
export function asEllipse(region) {
  if (!isBox(region)) return region;
  const [x, y, width, height] = region;
  return [x + (width - 1) / 2, y + (height - 1) / 2, width / 2, height / 2, 0];
}

/** Return the box around a region. */
export function boxAround(region) {
  if (isBox(region)) return region;
  const [x, y, a, b, theta] = region;
  const width = Math.hypot(a * Math.cos(theta), b * Math.sin(theta));
  const height = Math.hypot(a * Math.sin(theta), b * Math.cos(theta));
  return [x - width + 0.5, y - height + 0.5, 2 * width, 2 * height];
}

export const moved = ([x, y, ...rest], dx, dy) => [x + dx, y + dy, ...rest];

/** Return a region made larger or smaller about its center, by factors along its own axes. */
export function scaled(region, across, along = across) {
  if (!isBox(region)) {
    const [x, y, a, b, theta] = region;
    return [x, y, Math.max(1, a * across), Math.max(1, b * along), theta];
  }
  const [x, y, width, height] = region;
  const wide = Math.max(2, width * across);
  const high = Math.max(2, height * along);
  return [x + (width - wide) / 2, y + (height - high) / 2, wide, high];
}

/** Return an ellipse turned by an angle in radians; a box becomes an ellipse first. */
export function turned(region, angle) {
  const [x, y, a, b, theta] = asEllipse(region);
  return [x, y, a, b, theta + angle];
}

/** Return the box or the ellipse between two corners, at least two pixels wide and high. */
export function between([x0, y0], [x1, y1], kind) {
  const width = Math.max(2, Math.abs(x1 - x0));
  const height = Math.max(2, Math.abs(y1 - y0));
  const box = [Math.min(x0, x1) + 0.5, Math.min(y0, y1) + 0.5, width, height];
  return kind === "box" ? box : asEllipse(box);
}

/** Return a point in the axes of a region: center 0, 0 and half-axes 1, 1. */
function within(region, [x, y]) {
  const [cx, cy, a, b, theta] = asEllipse(region);
  const [dx, dy] = [x - cx, y - cy];
  const [cos, sin] = [Math.cos(theta), Math.sin(theta)];
  return [(dx * cos + dy * sin) / a, (dy * cos - dx * sin) / b];
}

/** Return whether a point lies in a region. */
export function contains(region, point) {
  const [u, v] = within(region, point);
  return isBox(region) ? Math.abs(u) <= 1 && Math.abs(v) <= 1 : u * u + v * v <= 1;
}

/** Return a point given in the axes of a region, in pixels of the film. */
function pointOf(region, u, v) {
  const [x, y, a, b, theta] = asEllipse(region);
  const [cos, sin] = [Math.cos(theta), Math.sin(theta)];
  return [x + u * a * cos - v * b * sin, y + u * a * sin + v * b * cos];
}

/** Return the handles of a region: corners of a box; ends of the axes of an ellipse, and one to turn it. */
export function handles(region, reach = 0) {
  const names = isBox(region)
    ? { nw: [-1, -1], ne: [1, -1], se: [1, 1], sw: [-1, 1] }
    : { w: [-1, 0], n: [0, -1], e: [1, 0], s: [0, 1], turn: [1 + reach / asEllipse(region)[2], 0] };
  return Object.entries(names).map(([name, [u, v]]) => ({ name, point: pointOf(region, u, v) }));
}

/** Return the region after one of its handles was dragged to a point. The other side stays. */
export function dragged(region, handle, point) {
  if (isBox(region)) {
    const [x, y, width, height] = region;
    const fixed = [
      handle.includes("w") ? x + width - 0.5 : x - 0.5,
      handle.includes("n") ? y + height - 0.5 : y - 0.5,
    ];
    return between(fixed, point, "box");
  }
  const [x, y, a, b, theta] = region;
  if (handle === "turn") return [x, y, a, b, Math.atan2(point[1] - y, point[0] - x)];
  const [u, v] = within(region, point);
  const sign = handle === "e" || handle === "s" ? 1 : -1;
  const horizontal = handle === "e" || handle === "w";
  const half = Math.max(1, ((sign * (horizontal ? u * a : v * b)) + (horizontal ? a : b)) / 2);
  const shift = sign * (half - (horizontal ? a : b));
  const [cx, cy] = pointOf(region, horizontal ? shift / a : 0, horizontal ? 0 : shift / b);
  return [cx, cy, horizontal ? half : a, horizontal ? b : half, theta];
}

/** Return the ellipse that holds 95 % of a Gaussian with this 2x2 covariance [[xx, xy], [xy, yy]]. */
export function covarianceEllipse([x, y], [[xx, xy], [, yy]]) {
  const mean = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const radius = (variance) => Math.sqrt(Math.max(0, variance) * 5.991); // chi-square, 2 degrees
  return [x, y, radius(mean + apart), radius(mean - apart), Math.atan2(2 * xy, xx - yy) / 2];
}

/** Return a region with numbers that people read: two decimals, the angle with four. */
export function rounded(region) {
  return region.map((value, place) => Number(value.toFixed(place === 4 ? 4 : 2)));
}
