// Lines, zones and the ground, as they are drawn corner by corner.

import { announce } from "./announce.js";

const LEAST = 5; // pixels of the film that a line must have

/** End a line that was dragged. */
export async function endLine({ store, actions }) {
  const { corners } = store.state;
  store.set({ corners: [] });
  if (corners.length < 2) return;
  const [[x1, y1], [x2, y2]] = corners;
  if (Math.hypot(x2 - x1, y2 - y1) < LEAST) return;
  const line = { points: [x1, y1, x2, y2].map(tenth), name: "", label: ["in", "out"] };
  await actions.setPlaces(({ lines }) => ({ lines: [...lines, line] }));
}

/** Add a corner of a zone, or a point of the ground. */
export function addCorner(app, point, near) {
  const { store } = app;
  const { tool, corners } = store.state;
  const [first] = corners;
  const closes = first && Math.hypot(first[0] - point[0], first[1] - point[1]) < near;
  if (tool === "zone" && corners.length >= 3 && closes) endZone(app);
  else if (tool === "ground" && corners.length >= 4) store.set({ corners: [point] });
  else store.set({ corners: [...corners, point] });
}

/** Close the zone whose corners were clicked. */
export async function endZone({ store, actions }) {
  const { corners } = store.state;
  if (corners.length < 3) {
    announce("A zone needs three corners or more.");
    return;
  }
  store.set({ corners: [] });
  const zone = { points: corners.flat().map(tenth), name: "" };
  await actions.setPlaces(({ zones }) => ({ zones: [...zones, zone] }));
}

/** Set the ground from four points and their places in metres, X and Y of each in turn. */
export async function endGround({ store, actions }, metres) {
  const ground = store.state.corners.map(([x, y], at) => [tenth(x), tenth(y), ...metres.slice(2 * at, 2 * at + 2)]);
  if (await actions.setPlaces(() => ({ ground }))) store.set({ corners: [], tool: "select" });
}

const tenth = (value) => Number(value.toFixed(1));
