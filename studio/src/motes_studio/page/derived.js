// What follows from the state: nothing here is kept.

import { boxAround, isBox, rounded } from "./geometry.js";

export const itemOf = (state, object) =>
  state.session?.objects.find((item) => item.object === object) ?? null;

export const selectedItem = (state) => itemOf(state, state.selected);

export const rowOf = (state, object, frame) => state.rows.get(object)?.[frame] ?? null;

export const keyframeOf = (item, frame) => item.keyframes.find((key) => key.frame === frame) ?? null;

export const isAbsent = (item, frame) =>
  item.absent.some(([first, last]) => first <= frame && frame <= last);

/** Return the ellipse of a row; null if it has no place. */
export const ellipseOf = (row) =>
  row && Number.isFinite(row.x) && row.a !== null ? [row.x, row.y, row.a, row.b, row.theta] : null;

/** Return the region of an object in a frame: as drawn, else as tracked, else null. */
export function regionOf(state, item, frame) {
  const drawn = keyframeOf(item, frame);
  if (drawn) return drawn.region;
  if (isAbsent(item, frame)) return null;
  const ellipse = ellipseOf(rowOf(state, item.object, frame));
  if (!ellipse) return null;
  return item.keyframes.every(({ region }) => isBox(region)) ? rounded(boxAround(ellipse)) : ellipse;
}

/** Return a region to begin a correction with: of the frame, or of the nearest frame that has one. */
export function nearestRegion(state, item, frame) {
  const here = regionOf(state, item, frame);
  if (here) return here;
  const rows = state.rows.get(item.object) ?? [];
  for (let away = 1; away <= 100; away += 1) {
    for (const at of [frame - away, frame + away]) {
      const ellipse = ellipseOf(rows[at]);
      if (ellipse) return regionOf(state, item, at);
    }
  }
  const far = ({ frame: at }) => Math.abs(at - frame);
  const near = [...item.keyframes].sort((one, two) => far(one) - far(two))[0];
  return near?.region ?? null;
}

export const runningJobs = (state) =>
  [...state.jobs.values()].filter(({ status }) => status === "running" || status === "waiting");

/** Return the objects that are not hidden. */
export const shownItems = (state) =>
  state.session?.objects.filter(({ object }) => !state.hidden.has(object)) ?? [];

/** Return the time of a frame in seconds. */
export const timeOf = ({ times, film }, frame) => times[frame] ?? frame / film.fps;

/** Return the frame that is seen at a time: the last one that has begun. */
export function frameAt({ times, film }, seconds) {
  if (!times.length) return Math.min(film.frames - 1, Math.floor(seconds * film.fps + 1e-6));
  let [low, high] = [0, times.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= seconds) low = middle;
    else high = middle;
  }
  return low;
}

/** Return a set with a member, or without it. */
export const withOrWithout = (set, member, on) => new Set(on ? [...set, member] : [...set].filter((each) => each !== member));

/** Return a number for people, or a dash. */
export const shown = (value, digits = 2) =>
  value === null || value === undefined || !Number.isFinite(value) ? "–" : value.toFixed(digits);

/** Return a count with its noun, as "1 frame" or "2 frames". */
export const plural = (count, thing) => `${count} ${thing}${count === 1 ? "" : "s"}`;

/** Return seconds as 1:02 or 1:02:03. */
export function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const tail = String(whole % 60).padStart(2, "0");
  return hours ? `${hours}:${String(minutes).padStart(2, "0")}:${tail}` : `${minutes}:${tail}`;
}
