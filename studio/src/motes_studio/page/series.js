// What the timeline shows: for each lane, numbers of each frame out of an object's rows.

/** The mean side of the ellipse's box, in pixels. */
const side = ({ a, b }) => (isPlace(a) ? 2 * Math.sqrt(a * b) : NaN);

/** Whether a number of a row is known; null would be taken for 0. */
const isPlace = (value) => value !== null && value !== undefined;

/** The lanes: the last three are the cue weights, and figures 12 and 7 of Nummiaro et al. */
export const LANES = [
  { name: "confidence", label: "Confidence", low: 0, high: 1, value: (row) => row.confidence },
  { name: "belief", label: "Is it the target?", low: 0, high: 1, value: (row) => row.belief },
  { name: "size", label: "Size", unit: "px", low: 0, value: side },
  { name: "speed", label: "Speed", unit: "px/frame", low: 0, value: speed },
  { name: "distance", label: "Distance", low: 0, high: 1, value: (row) => row.distance },
  { name: "particles", label: "Effective N", low: 0, value: (row) => row.effective_sample_size },
  { name: "cues", label: "Cue weights", low: 0, high: 1, value: null },
  { name: "supporting", label: "Supporting", low: 0, value: ({ supporting }) => supporting },
  { name: "milliseconds", label: "Time, ms", low: 0, value: ({ milliseconds }) => milliseconds },
];

/** What the timeline shows of the many-object mode: the number of objects. */
export const SCENE_LANES = [
  { name: "objects", label: "Objects", low: 0, value: ({ objects }) => objects.length },
];

function speed(row, before) {
  if (!before || before.frame === row.frame || !isPlace(row.x) || !isPlace(before.x)) return NaN;
  return Math.hypot(row.x - before.x, row.y - before.y) / Math.abs(row.frame - before.frame);
}

/** Whether a frame has nothing to show: the object is not there. */
export const isGap = ({ status }) => status === "absent";

/** Return per column of a plot the smallest and largest value of its frames: [low, high] or null. */
export function columns(rows, value, { first, last, count }) {
  const found = new Array(count).fill(null);
  let before = rows[first - 1];
  for (let frame = Math.max(0, first); frame <= last && frame < rows.length; frame += 1) {
    const row = rows[frame];
    if (!row || isGap(row)) {
      before = undefined;
      continue;
    }
    const number = value(row, before);
    before = row;
    if (!Number.isFinite(number)) continue;
    const column = Math.min(count - 1, Math.floor(((frame - first) / (last - first + 1)) * count));
    const range = found[column];
    if (!range) found[column] = [number, number];
    else if (number < range[0]) range[0] = number;
    else if (number > range[1]) range[1] = number;
  }
  return found;
}

/** Return the largest value of all columns, at least 1e-9. */
export const highest = (ranges) =>
  ranges.reduce((most, range) => (range && range[1] > most ? range[1] : most), 1e-9);
