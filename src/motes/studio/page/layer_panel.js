// Which layers are shown, and the plots of what the tracker saw in this frame.

import { announce } from "./announce.js";
import { ask } from "./api.js";
import { color, element, field, fill, fillAnew, sized } from "./dom.js";
import { selectedItem, runningJobs, withOrWithout } from "./derived.js";
import { LANES } from "./series.js";

const ALWAYS = [
  ["ellipse", "Ellipse"],
  ["labels", "Names"],
  ["covariance", "Covariance"],
  ["particles", "Particles"],
  ["trails", "Trails"],
  ["places", "Places"],
];
const ASKED = ["particles", "rho"];
const PATIENCE = 120; // milliseconds that a frame must stay before its layers are asked for

export function mountLayerPanel(app) {
  const { store } = app;
  const boxes = element("div", { class: "checks" });
  const surface = element("select", { onchange: ({ target }) => chooseSurface(store, target.value) });
  const plots = element("div", { class: "plots" });
  const lanes = element("div", { class: "checks" }, LANES.map(({ name, label, unit }) =>
    check(unit ? `${label}, ${unit}` : label, store.state.lanes.has(name), (on) => store.set({ lanes: withOrWithout(store.state.lanes, name, on) }))));
  const panel = element("div", { class: "tabpanel" },
    element("section", { class: "panel" }, element("h2", {}, "Over the film"), boxes, field("Surface around the target", surface)),
    element("section", { class: "panel" }, element("h2", {}, "Target model and estimate"), plots),
    element("section", { class: "panel" }, element("h2", {}, "Timeline"), lanes));
  store.on(["shown"], ({ shown }) => fillAnew(boxes, [...shown], () => ALWAYS.map(([name, label]) =>
    check(label, shown.has(name), (on) => store.set({ shown: withOrWithout(store.state.shown, name, on) })))));
  store.on(["session", "selected", "shown"], (state) => paintSurfaces(surface, state));
  store.on(["looked", "looks", "pictured", "selected"], (state) => paintPlots(plots, state));
  let timer = 0;
  store.on(["pictured", "selected", "shown", "tab", "playing", "jobs", "connected"], () => {
    clearTimeout(timer);
    timer = setTimeout(() => look(store), PATIENCE);
  });
  return panel;
}

function check(label, checked, onchange) {
  return element("label", { class: "check" },
    element("input", { type: "checkbox", checked, onchange: ({ target }) => onchange(target.checked) }), label);
}

/** Only one surface is shown at a time: they would cover each other. */
function chooseSurface(store, name) {
  const others = [...store.state.shown].filter((layer) => layer !== "rho" && !layer.startsWith("cue:"));
  store.set({ shown: new Set(name ? [...others, name] : others) });
}

function paintSurfaces(select, state) {
  const cues = selectedItem(state)?.cues ?? [];
  const chosen = [...state.shown].find((layer) => layer === "rho" || layer.startsWith("cue:")) ?? "";
  const named = cues.map((cue) => [`cue:${cue}`, `Likelihood of ${cue}`]);
  fillAnew(select, cues, () => [["", "None"], ["rho", "ρ, similarity to the model"], ...named]
    .map(([value, label]) => element("option", { value }, label)));
  select.value = chosen;
}

/** Ask the server for what the shown layers need, once a frame stands still. */
function look(store) {
  const { state } = store;
  const item = selectedItem(state);
  if (!item?.tracked || state.playing || runningJobs(state).length || state.pictured === null) return;
  const wanted = ASKED.filter((layer) => state.shown.has(layer));
  if ([...state.shown].some((layer) => layer.startsWith("cue:"))) wanted.push("likelihoods");
  if (state.tab === "layers") wanted.push("histograms", "orientation");
  if (wanted.length) fetchLayers(store, item.object, wanted);
}

/** Fetch layers of the frame that is seen, unless they were asked for last; an earlier request is given up. */
async function fetchLayers(store, object, wanted) {
  const { asked, session, pictured: frame } = store.state;
  const about = [session.id, object, frame, session.revision].join();
  const key = [about, ...wanted].join();
  if (key === asked?.key) return;
  if (about !== asked?.about) store.set({ looked: null }); // the rows may be others now
  asked?.control.abort();
  const mine = { about, key, control: new AbortController() };
  store.set({ asked: mine });
  try {
    const address = `/api/sessions/${session.id}/layers/${frame}?object=${object}&layers=${wanted.join()}`;
    const layers = await ask(address, { signal: mine.control.signal });
    if (store.state.asked === mine) store.set({ looked: layers });
  } catch (error) {
    if (store.state.asked !== mine) return; // it was given up
    store.set({ asked: null });
    announce(error.message, "error");
  }
}

function paintPlots(root, { looked, pictured, selected }) {
  const here = looked && looked.frame === pictured && looked.object === selected;
  const pairs = here ? Object.entries(looked.histograms) : [];
  const turns = here ? Object.entries(looked.orientation) : [];
  if (!pairs.length && !turns.length) {
    const none = "This tracker compares no histograms; nummiaro does.";
    const later = "Histograms are shown where the film stands still in a tracked frame.";
    fill(root, element("p", { class: "muted" }, here ? none : later));
    return;
  }
  const canvases = pairs.map(([cue, { model, estimate }]) => plot(`${cue}: model and estimate`, [model, estimate]));
  canvases.push(...turns.map(([name, values]) => plot(`Orientation, ${name}`, [values])));
  fill(root, canvases.map(({ node }) => node), element("p", { class: "legend muted" },
    element("i", { class: "model" }), "Model", element("i", { class: "estimate" }), "Estimate"));
  for (const { draw } of canvases) draw();
}

/** A plot of one or two histograms: the first one filled, the second one as a line. */
function plot(title, [filled, line]) {
  const canvas = element("canvas", { class: "plot", role: "img", "aria-label": title });
  const node = element("figure", {}, element("figcaption", { class: "muted" }, title), canvas);
  const draw = () => {
    const context = sized(canvas);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const most = Math.max(...filled, ...(line ?? []), 1e-9);
    const bin = width / filled.length;
    context.fillStyle = color("--edge");
    filled.forEach((value, at) => context.fillRect(at * bin, height * (1 - value / most), Math.max(1, bin - 0.5), (height * value) / most));
    if (!line) return;
    context.strokeStyle = color("--accent");
    context.lineWidth = 1.5;
    context.beginPath();
    line.forEach((value, at) => {
      const y = Math.max(1, height * (1 - value / most));
      context.lineTo(at * bin, y);
      context.lineTo((at + 1) * bin, y);
    });
    context.stroke();
  };
  return { node, draw };
}
