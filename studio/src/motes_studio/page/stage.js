// The stage: the film's picture, and over it what is known of its objects.

import { calm, element, sized, textScale } from "./dom.js";
import { dashes, trackColor } from "./colors.js";
import { handles } from "./geometry.js";
import { Viewport } from "./viewport.js";
import * as layers from "./layers.js";
import { ellipseOf, isAbsent, itemOf, keyframeOf, regionOf, rowOf, shownItems } from "./derived.js";

const ABOVE = [
  "session", "selected", "shown", "draft", "looked", "scene", "hidden", "tool",
  "corners",
];

export function mountStage(root, app) {
  const { store, pictures } = app;
  const film = element("canvas", { "aria-hidden": "true" });
  const over = element("canvas", {
    class: "over", tabindex: "0", role: "application", "aria-roledescription": "film",
    "aria-label": "Film. Press question mark for the keys.",
  });
  const caption = element("div", { class: "caption", "aria-hidden": "true" });
  const hint = element("div", { class: "caption hint" });
  root.append(film, over, caption, hint);

  const size = () => ({ width: root.clientWidth, height: root.clientHeight });
  const view = () => {
    const { view: chosen, film: facts } = store.state;
    return chosen ?? Viewport.fit(facts, size());
  };
  const below = () => store.state.film && paintFilm(film, store.state, pictures, view());
  const above = () => {
    if (!store.state.film) return;
    paintOver(over, store.state, view());
    caption.textContent = `Frame ${store.state.pictured ?? store.state.frame}`;
    hint.textContent = hintOf(store.state);
    hint.hidden = !hint.textContent;
  };
  const both = () => (below(), above());
  store.on(["picture", "film", "view", "looks"], both);
  store.on(["playing", "following"], below);
  store.on(ABOVE, above);
  store.on(["rows"], calm(above));
  new ResizeObserver(both).observe(root);
  return { canvas: over, view, size };
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

function paintOver(canvas, state, view) {
  const context = sized(canvas);
  const frame = state.pictured;
  if (frame === null) return;
  const { scale } = view;
  context.translate(view.x + scale / 2, view.y + scale / 2);
  context.scale(scale, scale);
  const size = scale / textScale(); // lines and names grow with the text of the page
  const names = []; // that are drawn
  for (const item of shownItems(state)) paintItem(context, state, item, frame, size, names);
  paintScene(context, state, frame, size, names);
  paintPlaces(context, state, size);
  paintDraft(context, state, size);
}

function paintItem(context, state, item, frame, scale, names) {
  const { shown: wanted, draft, selected, looked } = state;
  const style = { color: item.color, scale, dash: dashes(placeOf(state, item)) };
  const row = rowOf(state, item.object, frame);
  const overlay = row?.final ? null : state.overlays.get(item.object)?.get(frame) ?? null;
  if (wanted.has("trails")) layers.drawTrail(context, state.rows.get(item.object) ?? [], frame, style);
  const seen = overlay ?? (looked?.frame === frame && looked.object === item.object ? looked : null);
  if (wanted.has("particles") && seen) {
    layers.drawParticles(context, seen.particles, seen.weights, { scale });
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
    layers.drawLabel(context, region, item.name + note, style, names);
  }
  const own = regionOf(state, item, frame); // what is dragged; a run's newest ellipse is not
  if (own && item.object === selected && state.tool === "select") {
    layers.drawHandles(context, handles(own, 22 / scale), style);
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

function paintScene(context, { scene, shown: wanted }, frame, scale, names) {
  for (const object of scene[frame]?.objects ?? []) {
    const style = { color: trackColor(object.id), scale, dash: dashes(object.id) };
    const region = [object.x, object.y, object.width, object.height];
    const hidden = object.occluded_by !== null || object.status !== "tracking";
    if (wanted.has("ellipse")) layers.drawRegion(context, region, { ...style, width: hidden ? 1 : 2 });
    if (wanted.has("labels")) {
      layers.drawLabel(context, region, `${object.id}${object.label ? ` ${object.label}` : ""}`, style, names);
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

const TOUCH = matchMedia("(pointer: coarse)"); // a screen for fingers, where there may be no key

const HINTS = {
  box: "Drag a box around the object",
  ellipse: "Drag an ellipse over the object; then turn it by its handle",
  line: "Drag a line; the short stroke shows the way in",
  zone: TOUCH.matches ? "Tap the corners; tap the first one to close" : "Click the corners; press Enter or click the first one to close",
  ground: `${TOUCH.matches ? "Tap" : "Click"} four points of the ground that you know in metres`,
};

function hintOf({ tool, draft, corners, redrawing, session, selected, scene }) {
  if (draft?.byKeys) return "Arrows move, Ctrl and arrows resize, [ ] turn; Enter sets, Escape ends";
  if (tool === "ground" && corners.length) return `Point ${corners.length} of 4: enter its metres in Count`;
  if (redrawing) return `Draw ${itemOf({ session }, selected)?.name ?? "the object"} again in this frame`;
  const first = TOUCH.matches
    ? "Tap the box above the film and drag around an object; then tap Track"
    : "Press B and drag a box around an object; then T tracks it";
  return HINTS[tool] ?? (tool === "select" && !session.objects.length && !scene.length ? first : "");
}
