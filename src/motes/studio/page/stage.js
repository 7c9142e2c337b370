// The stage: the film's picture, and over it what is known of its objects.

import { calm, element, sized, textScale } from "./dom.js";
import { dashes, trackColor } from "./colors.js";
import { handles } from "./geometry.js";
import { Viewport } from "./viewport.js";
import * as layers from "./layers.js";
import { ellipseOf, isAbsent, itemOf, keyframeOf, regionOf, rowOf, shown, shownItems } from "./derived.js";

const ABOVE = [
  "session", "selected", "shown", "draft", "looked", "scene", "hidden", "tool",
  "corners",
];

export function mountStage(root, app, side) {
  const { store, pictures } = app;
  const film = element("canvas", { "aria-hidden": "true" });
  const over = element("canvas", {
    class: "over", tabindex: "0", role: "application", "aria-roledescription": "film",
    "aria-label": side === 0 ? "Film. Press question mark for the keys." : "Film with the other tracker",
  });
  const caption = element("div", { class: "caption", "aria-hidden": "true" });
  const hint = element("div", { class: "caption hint" });
  const box = element("div", { class: "stage" }, film, over, caption, hint);
  root.append(box);

  const size = () => ({ width: box.clientWidth, height: box.clientHeight });
  const view = () => {
    const { view: chosen, film: facts } = store.state;
    return chosen ?? Viewport.fit(facts, size());
  };
  const below = () => store.state.film && paintFilm(film, store.state, pictures, view());
  const above = () => {
    if (!store.state.film) return;
    paintOver(over, store.state, view(), side);
    caption.textContent = captionOf(store.state, side);
    hint.textContent = hintOf(store.state);
    hint.hidden = !hint.textContent || side > 0;
  };
  const both = () => (below(), above());
  const offs = [
    store.on(["picture", "film"], both),
    store.on(["playing", "following"], below),
    store.on(["view", "looks"], both),
    store.on(ABOVE, above),
    store.on(["rows"], calm(above)),
  ];
  const resized = new ResizeObserver(both);
  resized.observe(box);
  return {
    canvas: over,
    view,
    size,
    remove() {
      offs.forEach((off) => off());
      resized.disconnect();
      box.remove();
    },
  };
}

/** Paint the picture. The finest scaling takes a fifth of this thread's time for one, and shows at rest alone. */
function paintFilm(canvas, { film, pictured, playing, following }, pictures, view) {
  const context = sized(canvas);
  const picture = pictured === null ? null : pictures.get(pictured);
  if (!picture) return;
  context.imageSmoothingEnabled = view.scale < 4;
  context.imageSmoothingQuality = playing || following ? "low" : "high";
  context.drawImage(picture, view.x, view.y, film.width * view.scale, film.height * view.scale);
}

function paintOver(canvas, state, view, side) {
  const context = sized(canvas);
  const frame = state.pictured;
  if (frame === null) return;
  const { scale } = view;
  context.translate(view.x + scale / 2, view.y + scale / 2);
  context.scale(scale, scale);
  const size = scale / textScale(); // lines and names grow with the text of the page
  const items = shownItems(state, side);
  paintLooked(context, state, items, frame, size);
  for (const item of items) paintItem(context, state, item, frame, size);
  paintScene(context, state, frame, size);
  paintPlaces(context, state, size);
  paintDraft(context, state, size);
}

/** Surfaces and particles that the person asked for in this frame. */
function paintLooked(context, { looked, shown: wanted }, items, frame, scale) {
  if (looked?.frame !== frame || !items.some(({ object }) => object === looked.object)) return;
  if (wanted.has("rho") && looked.rho) layers.drawSurface(context, looked.rho);
  const cue = [...wanted].find((name) => name.startsWith("cue:"))?.slice(4);
  if (cue && looked.likelihoods[cue]) layers.drawSurface(context, looked.likelihoods[cue]);
  if (wanted.has("particles")) layers.drawParticles(context, looked.particles, looked.weights, { scale });
}

function paintItem(context, state, item, frame, scale) {
  const { shown: wanted, draft, selected } = state;
  const style = { color: item.color, scale, dash: dashes(placeOf(state, item)) };
  const row = rowOf(state, item.object, frame);
  const overlay = row?.final ? null : state.overlays.get(item.object)?.get(frame) ?? null;
  if (wanted.has("trails")) layers.drawTrail(context, state.rows.get(item.object) ?? [], frame, style);
  if (wanted.has("particles") && overlay) {
    layers.drawParticles(context, overlay.particles, overlay.weights, { scale });
  }
  if (draft?.object === item.object) return;
  const drawn = keyframeOf(item, frame);
  const region = drawn?.region ?? overlay?.ellipse ?? regionOf(state, item, frame);
  if (!region || isAbsent(item, frame)) return;
  if (wanted.has("covariance")) paintCovariance(context, row, overlay, style);
  const sure = drawn || !row || row.status === "tracking";
  if (wanted.has("ellipse")) {
    layers.drawRegion(context, region, { ...style, width: sure ? 2.2 : 1.2 });
  }
  if (wanted.has("labels")) {
    const note = drawn ? " ◆" : sure ? "" : ` (${row.status})`;
    layers.drawLabel(context, region, item.name + note, style);
  }
  if (item.object === selected && state.tool === "select" && item.compared === null) {
    layers.drawHandles(context, handles(region, 22 / scale), style);
  }
}

const placeOf = (state, item) => state.session.objects.indexOf(item);

function paintCovariance(context, row, overlay, style) {
  if (overlay) {
    const [xx, xy, yy] = overlay.covariance;
    layers.drawCovariance(context, overlay.ellipse, [[xx, xy], [xy, yy]], style);
  } else if (row?.deviations && ellipseOf(row)) {
    const [x, y] = row.deviations;
    layers.drawCovariance(context, ellipseOf(row), [[x * x, 0], [0, y * y]], style);
  }
}

function paintScene(context, { scene, shown: wanted }, frame, scale) {
  for (const object of scene[frame]?.objects ?? []) {
    const style = { color: trackColor(object.id), scale, dash: dashes(object.id) };
    const region = [object.x, object.y, object.width, object.height];
    const hidden = object.occluded_by !== null || object.status !== "tracking";
    if (wanted.has("ellipse")) layers.drawRegion(context, region, { ...style, width: hidden ? 1 : 2 });
    if (wanted.has("labels")) {
      layers.drawLabel(context, region, `${object.id}${object.label ? ` ${object.label}` : ""}`, style);
    }
    if (wanted.has("trails")) paintSceneTrail(context, scene, object.id, frame, style);
  }
}

function paintSceneTrail(context, scene, id, frame, style) {
  const rows = [];
  for (let at = Math.max(0, frame - 60); at <= frame; at += 1) {
    const object = scene[at]?.objects.find((other) => other.id === id);
    if (object) rows[at] = { x: object.x + object.width / 2, y: object.y + object.height };
  }
  layers.drawTrail(context, rows, frame, style);
}

function paintPlaces(context, { session, corners, tool, shown: wanted }, scale) {
  const style = { color: "#f0e442", scale };
  const { lines, zones, ground } = session.places;
  if (wanted.has("places")) {
    lines.forEach(({ points, name, label }, at) => layers.drawLine(context, points, [name || `line ${at + 1}`, label[0]], style));
    zones.forEach(({ points, name }, at) => {
      layers.drawZone(context, pairs(points), name || `zone ${at + 1}`, { ...style, color: "#56b4e9" });
    });
    if (ground && tool === "ground" && !corners.length) {
      layers.drawPoints(context, ground.map(([x, y]) => [x, y]), { ...style, color: "#cc79a7" });
    }
  }
  if (!corners.length) return;
  if (tool === "line" && corners.length === 2) layers.drawLine(context, corners.flat(), ["", "in"], style);
  else if (tool === "zone") layers.drawZone(context, corners, "", { ...style, color: "#56b4e9" });
  layers.drawPoints(context, corners, { ...style, color: "#cc79a7" });
}

const pairs = (numbers) =>
  Array.from({ length: numbers.length / 2 }, (_, at) => [numbers[2 * at], numbers[2 * at + 1]]);

function paintDraft(context, { draft }, scale) {
  if (!draft) return;
  const style = { color: draft.color, scale, width: 2.2 };
  layers.drawRegion(context, draft.region, style);
  layers.drawHandles(context, handles(draft.region, 22 / scale), style);
}

function captionOf(state, side) {
  if (state.beside === null) return `Frame ${state.pictured ?? state.frame}`;
  const item = shownItems(state, side)[0];
  if (!item) return "";
  const row = rowOf(state, item.object, state.pictured);
  const tracker = item.config === null ? item.preset : "own configuration";
  return `${tracker} · ${row ? `${row.status}, confidence ${shown(row.confidence)}` : "not tracked here"}`;
}

const HINTS = {
  box: "Drag a box around the object",
  ellipse: "Drag an ellipse over the object; then turn it by its handle",
  line: "Drag a line; the short stroke shows the way in",
  zone: "Click the corners; press Enter or click the first one to close",
  ground: "Click four points of the ground that you know in metres",
};

function hintOf({ tool, draft, corners, redrawing, session, selected, scene }) {
  if (draft?.byKeys) return "Arrows move, Ctrl and arrows resize, [ ] turn; Enter sets, Escape ends";
  if (tool === "ground" && corners.length) return `Point ${corners.length} of 4: enter its metres in Count`;
  if (redrawing) return `Draw ${itemOf({ session }, selected)?.name ?? "the object"} again in this frame`;
  const first = "Press B and drag a box around an object; then T tracks it";
  return HINTS[tool] ?? (tool === "select" && !session.objects.length && !scene.length ? first : "");
}
