// The timeline: status, keyframes and the lanes of numbers of the selected object, frame by frame.

import { calm, color, element, scrub, sized, textScale } from "./dom.js";
import { columns, highest, isGap, LANES, SCENE_LANES } from "./series.js";
import { COLORS } from "./colors.js";
import { shown } from "./derived.js";

const STATUS = {
  tracking: "--tracking",
  interpolated: "--interpolated",
  occluded: "--interpolated",
  searching: "--searching",
  lost: "--lost",
  absent: "--absent",
};
const LABELS = 132; // pixels of a small window
const STATUS_HEIGHT = 18;

export function mountTimeline(root, { store, player }) {
  const canvas = element("canvas", {
    class: "timeline",
    tabindex: "0",
    role: "slider",
    "aria-label": "Timeline",
    "aria-valuemin": "0",
  });
  root.append(canvas);
  const draw = () => paint(canvas, store.state);
  store.on(["session", "selected", "frame", "range", "film", "lanes", "doubts", "looks", "events"], draw);
  store.on(["rows", "scene"], calm(draw));
  new ResizeObserver(draw).observe(canvas);
  scrub(canvas, (x) => store.state.film && player.go(frameAt(canvas, store.state, x)));
  canvas.addEventListener("wheel", (event) => zoom(event), { passive: false });

  function zoom(event) {
    const { film, range } = store.state;
    if (!film) return;
    event.preventDefault();
    const [first, last] = range ?? [0, film.frames - 1];
    const middle = frameAt(canvas, store.state, event.offsetX);
    const factor = event.deltaY < 0 ? 0.8 : 1.25;
    const length = Math.min(film.frames, Math.max(30, (last - first + 1) * factor));
    const share = (middle - first) / Math.max(1, last - first + 1);
    const start = Math.round(Math.min(film.frames - length, Math.max(0, middle - share * length)));
    store.set({ range: length >= film.frames ? null : [start, start + Math.round(length) - 1] });
  }
}

/** Return the frames that the timeline shows: first and last. */
const shownRange = ({ film, range }) => range ?? [0, film.frames - 1];

function frameAt(canvas, state, x) {
  const [first, last] = shownRange(state);
  const labels = LABELS * textScale();
  const share = (x - labels) / Math.max(1, canvas.clientWidth - labels);
  return Math.min(last, Math.max(first, first + Math.floor(share * (last - first + 1))));
}

function paint(canvas, state) {
  const context = sized(canvas);
  const { film, frame, selected, session } = state;
  if (!film) return;
  const [first, last] = shownRange(state);
  const unit = textScale();
  context.scale(unit, unit);
  const [width, height] = [canvas.clientWidth / unit - LABELS, canvas.clientHeight / unit];
  const place = (at) => LABELS + ((at - first) / (last - first + 1)) * width;
  const object = session?.objects.find((item) => item.object === selected);
  const rows = object ? state.rows.get(selected) ?? [] : state.scene;
  const wanted = LANES.filter(({ name }) => state.lanes.has(name));
  const lanes = !object && state.scene.length ? SCENE_LANES : wanted;
  const tall = (height - STATUS_HEIGHT) / Math.max(1, lanes.length);
  canvas.setAttribute("aria-valuemax", film.frames - 1);
  canvas.setAttribute("aria-valuenow", frame);
  canvas.setAttribute("aria-valuetext", spoken(frame, rows[frame]));
  context.font = "11px system-ui, sans-serif";
  context.textBaseline = "middle";
  paintStatus(context, { rows, first, last, width });
  paintMarks(context, { object, state, place, first, last });
  const one = Math.max(1, width / (last - first + 1));
  lanes.forEach((lane, number) => {
    const top = STATUS_HEIGHT + number * tall;
    paintLane(context, lane, {
      rows, first, last, width, top, tall, frame, shade: object?.color, cues: object?.cues ?? [],
    });
  });
  context.fillStyle = color("--accent");
  context.fillRect(place(frame) + one / 2 - 0.75, 0, 1.5, height);
}

const spoken = (frame, row) =>
  row?.status ? `frame ${frame}, ${row.status}, confidence ${shown(row.confidence)}` : `frame ${frame}`;

function paintStatus(context, { rows, first, last, width }) {
  context.fillStyle = color("--muted");
  context.fillText("Status", 10, STATUS_HEIGHT / 2);
  context.fillStyle = color("--empty");
  context.fillRect(LABELS, 5, width, 8);
  const count = Math.max(1, Math.floor(width));
  const per = (last - first + 1) / count;
  for (let column = 0; column < count; column += 1) {
    const row = rows[Math.floor(first + column * per)];
    if (!row) continue;
    context.fillStyle = color(STATUS[row.status ?? "tracking"]);
    context.fillRect(LABELS + column, 5, 1.5, 8);
  }
}

function paintMarks(context, { object, state, place, first, last }) {
  const diamond = (x, fill) => {
    context.fillStyle = fill;
    context.beginPath();
    context.moveTo(x, 3);
    context.lineTo(x + 6, 9);
    context.lineTo(x, 15);
    context.lineTo(x - 6, 9);
    context.fill();
    context.lineWidth = 1;
    context.strokeStyle = color("--panel");
    context.stroke();
  };
  const half = (place(first + 1) - place(first)) / 2;
  for (const { frame } of object?.keyframes ?? []) {
    if (frame >= first && frame <= last) diamond(place(frame) + half, color("--text"));
  }
  if (!object) paintEvents(context, state.events, place);
  for (const { frame } of (state.doubts.get(object?.object) ?? []).slice(0, 20)) {
    if (frame < first || frame > last) continue;
    const x = place(frame) + half;
    context.fillStyle = color("--doubt");
    context.beginPath();
    context.moveTo(x - 5, 0);
    context.lineTo(x + 5, 0);
    context.lineTo(x, 6);
    context.fill();
  }
}

/** Crossings, entries and exits of the many-object mode. */
function paintEvents(context, events, place) {
  context.fillStyle = color("--accent");
  for (const { frame, place: where } of events) {
    if (where) context.fillRect(place(frame) - 1, 3, 2, 12);
  }
}

function paintLane(context, lane, { rows, first, last, width, top, tall, frame, shade, cues }) {
  context.fillStyle = color("--line");
  context.fillRect(0, top, LABELS + width, 1);
  context.fillStyle = color("--muted");
  context.fillText(lane.label, 10, top + tall / 2);
  const span = { first, last, count: Math.max(1, Math.floor(width)) };
  const wires = lane.value ? [[null, lane.value]] : cueWires(cues);
  wires.forEach(([, value], number) => {
    const ranges = columns(rows, value, span);
    const high = lane.high ?? highest(ranges);
    const y = (at) => top + tall - 3 - ((at - lane.low) / (high - lane.low)) * (tall - 6);
    context.fillStyle = wires.length > 1 ? COLORS[number % COLORS.length].value : shade ?? color("--accent");
    context.strokeStyle = context.fillStyle;
    context.lineWidth = 1.5;
    paintWire(context, ranges, y, 1 + Math.ceil(width / (last - first + 1)));
  });
  const row = rows[frame];
  if (!row || isGap(row) || !lane.value) return;
  const number = lane.value(row, rows[frame - 1]);
  if (!Number.isFinite(number)) return;
  context.textAlign = "right";
  context.fillStyle = color("--text");
  context.fillText(number.toFixed(number < 10 && !Number.isInteger(number) ? 2 : 0), LABELS - 8, top + tall / 2);
  context.textAlign = "left";
}

/** One line through the columns; a gap of frames without a value stays a gap. */
function paintWire(context, ranges, y, reach) {
  let last = -Infinity;
  context.beginPath();
  ranges.forEach((range, column) => {
    if (!range) return;
    const x = LABELS + column + 0.5;
    if (column - last > reach) context.moveTo(x, y(range[0]) + 0.75);
    context.lineTo(x, y(range[0]));
    context.lineTo(x, y(range[1]));
    last = column;
  });
  context.stroke();
}

/** Return name and value of each cue. */
const cueWires = (cues) => cues.map((name, place) => [name, (row) => row.cue_weights?.[place]]);
