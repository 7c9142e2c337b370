// All keys. Each has a name for the help; a draft and the timeline have keys of their own.

import { endZone } from "./places.js";
import { moved, scaled, turned } from "./geometry.js";
import { nearestRegion, selectedItem } from "./derived.js";
import { nextColor } from "./colors.js";
import { read } from "./announce.js";

/** Return the keys of a session: [keys, what they do, action(event)]. */
function bindings(app) {
  const { player, actions, dialogs } = app;
  const tool = (name) => () => actions.choose(name);
  const go = (count) => (event) => player.step(count * (event.shiftKey ? 10 : 1));
  return [
    ["Film", [
      [[" "], "Play or pause", () => player.toggle()],
      [["ArrowLeft", "d"], "One frame back; with Shift ten", go(-1)],
      [["ArrowRight", "f"], "One frame forward; with Shift ten", go(1)],
      [["Home"], "First frame", () => player.go(0)],
      [["End"], "Last frame", () => player.go(Infinity)],
      [[",", "."], "Keyframe before, keyframe after", (event) => toKeyframe(app, event.key === "." ? 1 : -1)],
      [["+", "-", "0"], "Zoom in, zoom out, whole film", (event) => app.zoom(event.key)],
    ]],
    ["Objects", [
      [["v"], "Choose and move", tool("select")],
      [["b"], "Draw a box", tool("box")],
      [["e"], "Draw an ellipse", tool("ellipse")],
      [["h"], "Move the picture", tool("hand")],
      [["Enter"], "Draw or move by keys; set", () => enter(app)],
      [["Escape"], "End what was begun", tool("select")],
      [["ArrowUp", "ArrowDown"], "Object before, object after", (event) => other(app, event.key === "ArrowDown" ? 1 : -1)],
      [["t"], "Track", () => actions.track()],
    ]],
    ["Corrections", [
      [["n"], "Next doubtful frame", () => actions.nextDoubt()],
      [["k"], "Set or remove a keyframe", () => actions.toggleKeyframe()],
      [["a"], "Object is absent in this frame, or not", () => actions.toggleAbsent()],
      [["r"], "Draw the object again in this frame", () => actions.redraw()],
      [["s"], "Split the object here", () => actions.split()],
      [["Delete"], "Remove the object", () => actions.remove()],
      [["Ctrl+z"], "Undo", () => actions.undo()],
      [["Ctrl+y", "Ctrl+Shift+z"], "Redo", () => actions.redo()],
    ]],
    ["Page", [
      [["?"], "This help", () => dialogs.help()],
      [["x"], "Export", () => dialogs.exports()],
      [["c"], "Command line", () => dialogs.command()],
    ]],
  ];
}

const WORDS = {
  " ": "Space", ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓", Escape: "Esc",
};

/** Return what the help shows: groups of [keys, what they do]. */
export const helpOf = (app) =>
  bindings(app).map(([title, keys]) => [
    title,
    keys.map(([names, what]) => [names.map((name) => WORDS[name] ?? name), what]),
  ]);

export function mountKeyboard(app) {
  const actions = new Map(
    bindings(app).flatMap(([, keys]) => keys.flatMap(([names, , act]) => names.map((name) => [name, act]))),
  );
  document.addEventListener("keydown", (event) => {
    if (!app.store.state.session || document.querySelector("dialog[open]")) return;
    if (isTyping(event)) {
      const done = event.key === "Enter" && event.target.matches("input") && !event.defaultPrevented;
      if (done) app.stage.canvas.focus(); // else the next key would be typed, too
      return;
    }
    if (app.store.state.draft?.byKeys && shape(app, event)) {
      event.preventDefault();
      return;
    }
    const act = actions.get(nameOf(event));
    if (!act || ownsKey(event)) return;
    event.preventDefault();
    act(event);
  });
}

function nameOf(event) {
  const control = event.ctrlKey || event.metaKey;
  if (control) return `Ctrl+${event.shiftKey ? "Shift+" : ""}${event.key.toLowerCase()}`;
  if (event.altKey) return "";
  return event.key.length === 1 ? event.key.toLowerCase() : event.key;
}

const isTyping = ({ target }) =>
  target.matches("textarea, select, input:not([type=checkbox], [type=radio], [type=range], [type=color])");

/** Space and Enter press the button, and arrows change the tab or slider, that has the focus. */
function ownsKey({ target, key }) {
  if (key === " " || key === "Enter") return target.matches("button, a, summary, input, [role=tab]");
  return key.startsWith("Arrow") && target.matches("[role=tab], input, summary");
}

/** Change the draft by keys; return whether the key was one of these. */
function shape({ store }, event) {
  const { draft } = store.state;
  const step = event.shiftKey ? 10 : 1;
  const far = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] }[event.key];
  let region = null;
  if (far && (event.ctrlKey || event.metaKey)) {
    const grow = (count) => 1 + 0.02 * count;
    region = scaled(draft.region, grow(far[0]), grow(-far[1]));
  } else if (far) region = moved(draft.region, ...far);
  else if (event.key === "+" || event.key === "-") region = scaled(draft.region, event.key === "+" ? 1.05 : 1 / 1.05);
  else if (event.key === "[" || event.key === "]") region = turned(draft.region, (event.key === "]" ? step : -step) * 0.035);
  if (!region) return false;
  store.set({ draft: { ...draft, region } });
  read(`x ${Math.round(region[0])}, y ${Math.round(region[1])}`);
  return true;
}

/** Begin a draft, set it, or close a zone. */
function enter(app) {
  const { store, player, actions } = app;
  const { draft, tool, corners, redrawing, film, session, pictured, selected } = store.state;
  if (draft) {
    if (!draft.sent) actions.commit(draft);
    return;
  }
  if (tool === "zone" && corners.length) {
    endZone(app);
    return;
  }
  const item = selectedItem(store.state);
  const fresh = (tool === "box" || tool === "ellipse") && !redrawing;
  if (!fresh && !item) return;
  const middle = [film.width / 2, film.height / 2, film.width / 12, film.height / 8, 0];
  const box = [film.width * 0.42, film.height * 0.38, film.width / 6, film.height / 4].map(Math.round);
  const region = fresh ? (tool === "box" ? box : middle) : nearestRegion(store.state, item, pictured);
  const color = fresh ? nextColor(session.objects) : item.color;
  player.stay();
  store.set({ draft: { object: fresh ? null : selected, frame: pictured, color, region, byKeys: true } });
  read("Arrows move, Control and arrows resize, brackets turn, Enter sets, Escape ends");
}

function other({ store }, step) {
  const items = store.state.session.objects;
  if (!items.length) return;
  const at = items.findIndex(({ object }) => object === store.state.selected);
  const item = items[(at + step + items.length) % items.length];
  store.set({ selected: item.object });
  read(item.name);
}

function toKeyframe({ store, player }, direction) {
  const item = selectedItem(store.state);
  const frames = (item?.keyframes ?? []).map(({ frame }) => frame).sort((a, b) => a - b);
  const { frame } = store.state;
  const next = direction > 0 ? frames.find((at) => at > frame) : frames.reverse().find((at) => at < frame);
  if (next !== undefined) player.go(next);
}
