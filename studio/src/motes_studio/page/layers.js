// What is drawn over the film: each function draws one layer in pixels of the film.

import { asEllipse, covarianceEllipse, isBox } from "./geometry.js";
import { viridis } from "./colors.js";

const HALO = "rgba(0, 0, 0, 0.65)";

/** Trace the outline of a region. */
function outline(context, region) {
  context.beginPath();
  if (isBox(region)) {
    const [x, y, width, height] = region;
    context.rect(x - 0.5, y - 0.5, width, height);
  } else {
    const [x, y, a, b, theta] = region;
    context.ellipse(x, y, Math.max(a, 0.1), Math.max(b, 0.1), theta, 0, 2 * Math.PI);
  }
}

/** Stroke the current path in a color with a dark halo: visible on light and on dark pictures. */
function stroke(context, { color, scale, width = 2, dash = [] }) {
  context.setLineDash([]);
  context.lineWidth = (width + 2) / scale;
  context.strokeStyle = HALO;
  context.stroke();
  context.setLineDash(dash.map((length) => length / scale));
  context.lineWidth = width / scale;
  context.strokeStyle = color;
  context.stroke();
  context.setLineDash([]);
}

/** Draw a region: what is guessed or interpolated is thinner. */
export function drawRegion(context, region, style) {
  if (!region.every(Number.isFinite)) return;
  outline(context, region);
  stroke(context, style);
}

/** Return the part of the film that the canvas shows: left, top, right and bottom. */
function windowOf(context) {
  const inverse = context.getTransform().inverse();
  const { x: left, y: top } = inverse.transformPoint({ x: 0, y: 0 });
  const { x: right, y: bottom } = inverse.transformPoint({ x: context.canvas.width, y: context.canvas.height });
  return [left, top, right, bottom];
}

const ROWS = 5; // of names over a region, and under it, that are tried

/**
 * Return the left and the lower end of a name over a region, else under it, within the window and upon no other name.
 * In a crowd, where there is no such place, it is over the region.
 */
function placeOfLabel([x, y, a, b, theta], [width, height], [left, top, right, bottom], gap, names) {
  const high = Math.hypot(a * Math.sin(theta), b * Math.cos(theta)) + gap;
  const start = Math.max(left, Math.min(x - width / 2, right - width));
  const rows = Array.from({ length: ROWS }, (_, row) => [y - high - row * height, y + high + (row + 1) * height]);
  const places = rows.flat().map((low) => [start, Math.max(top + height, Math.min(low, bottom))]);
  const hides = ([at, low]) => names.some((other) =>
    at < other.left + other.width && other.left < at + width && low - height < other.low && other.low - other.height < low);
  return places.find((place) => !hides(place)) ?? places[0];
}

/** Draw a name beside a region, upon none of `names`, to which it is added; the text keeps its size on the screen. */
export function drawLabel(context, region, text, { color, scale }, names = []) {
  context.font = `600 ${12 / scale}px system-ui, sans-serif`;
  const width = context.measureText(text).width + 8 / scale;
  const height = 17 / scale;
  const [left, low] = placeOfLabel(asEllipse(region), [width, height], windowOf(context), 6 / scale, names);
  names.push({ left, low, width, height });
  context.fillStyle = "rgba(10, 12, 15, 0.78)";
  context.beginPath();
  context.roundRect(left, low - height, width, height, 3 / scale);
  context.fill();
  context.fillStyle = color;
  context.fillRect(left, low - 2 / scale, width, 2 / scale);
  context.fillStyle = "#fff";
  context.textBaseline = "middle";
  context.fillText(text, left + 4 / scale, low - height / 2 - 0.5 / scale);
}

/** Draw the ellipse that holds 95 % of the position's distribution. */
export function drawCovariance(context, at, covariance, { color, scale }) {
  const region = covarianceEllipse(at, covariance);
  if (!region.every(Number.isFinite) || region[2] <= 0) return;
  outline(context, region);
  context.fillStyle = `${color}33`;
  context.fill();
  stroke(context, { color, scale, width: 1.2, dash: [2, 3] });
}

/** Draw particles [x, y, a, b, theta]; the likelier one is lighter, and drawn last. */
export function drawParticles(context, particles, weights, { scale }) {
  const most = Math.max(...weights, 1e-12);
  const order = particles.map((_, place) => place).sort((one, two) => weights[one] - weights[two]);
  context.lineWidth = 1 / scale;
  for (const place of order) {
    const share = Math.sqrt(weights[place] / most);
    const [red, green, blue] = viridis(share);
    const [x, y, a, b, theta] = particles[place];
    context.strokeStyle = `rgba(${red}, ${green}, ${blue}, ${0.12 + 0.5 * share})`;
    context.beginPath();
    if (a > 0) context.ellipse(x, y, a, Math.max(b, 0.1), theta, 0, 2 * Math.PI);
    context.stroke();
    context.fillStyle = `rgb(${red}, ${green}, ${blue})`;
    context.beginPath();
    context.arc(x, y, 1.6 / scale, 0, 2 * Math.PI);
    context.fill();
  }
}

/** Draw the path of an object up to a frame; the last frames are stronger. */
export function drawTrail(context, rows, frame, { color, scale, length = 60 }) {
  const first = Math.max(0, frame - length);
  context.lineWidth = 2 / scale;
  context.strokeStyle = color;
  for (let at = first + 1; at <= frame; at += 1) {
    const [before, row] = [rows[at - 1], rows[at]];
    if (!before || !row || !Number.isFinite(before.x) || !Number.isFinite(row.x)) continue;
    context.globalAlpha = 0.15 + (0.85 * (at - first)) / length;
    context.beginPath();
    context.moveTo(before.x, before.y);
    context.lineTo(row.x, row.y);
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** Draw a line that is counted; a stroke from its middle to its left bears the name of that direction. */
export function drawLine(context, [x1, y1, x2, y2], [text, first], { color, scale }) {
  context.beginPath();
  context.moveTo(x1, y1);
  context.lineTo(x2, y2);
  const [mx, my] = [(x1 + x2) / 2, (y1 + y2) / 2];
  const length = Math.hypot(x2 - x1, y2 - y1) || 1;
  const [tx, ty] = [mx + ((y2 - y1) / length) * (18 / scale), my - ((x2 - x1) / length) * (18 / scale)];
  context.moveTo(mx, my);
  context.lineTo(tx, ty);
  stroke(context, { color, scale });
  drawLabel(context, [tx, ty, 1, 1, 0], first, { color, scale });
  if (text) drawLabel(context, [x1, y1, 1, 1, 0], text, { color, scale });
}

/** Draw a polygon with corners [[x, y], ...]. */
export function drawZone(context, corners, text, { color, scale }) {
  context.beginPath();
  corners.forEach(([x, y], place) => (place ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.closePath();
  context.fillStyle = `${color}22`;
  context.fill();
  stroke(context, { color, scale, dash: [6, 4] });
  const middle = corners.reduce(([sx, sy], [x, y]) => [sx + x, sy + y], [0, 0]);
  const center = middle.map((sum) => sum / corners.length);
  if (text) drawLabel(context, [...center, 1, 1, 0], text, { color, scale });
}

/** Draw numbered points, such as those of the ground. */
export function drawPoints(context, points, { color, scale }) {
  points.forEach(([x, y], place) => {
    context.beginPath();
    context.arc(x, y, 5 / scale, 0, 2 * Math.PI);
    stroke(context, { color, scale });
    drawLabel(context, [x, y, 6 / scale, 6 / scale, 0], String(place + 1), { color, scale });
  });
}

/** Draw the handles of a region that may be dragged. */
export function drawHandles(context, points, { color, scale }) {
  for (const { name, point } of points) {
    context.beginPath();
    if (name === "turn") context.arc(...point, 5 / scale, 0, 2 * Math.PI);
    else context.rect(point[0] - 4 / scale, point[1] - 4 / scale, 8 / scale, 8 / scale);
    context.fillStyle = "#fff";
    context.fill();
    context.lineWidth = 1.5 / scale;
    context.strokeStyle = color;
    context.stroke();
  }
}
