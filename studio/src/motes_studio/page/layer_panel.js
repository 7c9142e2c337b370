// Which layers are shown over the film and on the timeline.

import { announce } from "./announce.js";
import { ask } from "./api.js";
import { element, fillAnew } from "./dom.js";
import { isAbsent, selectedItem, runningJobs, withOrWithout } from "./derived.js";
import { LANES } from "./series.js";

const LAYERS = [
  ["ellipse", "Ellipse"],
  ["labels", "Names"],
  ["covariance", "Covariance"],
  ["particles", "Particles"],
  ["trails", "Trails"],
  ["places", "Places"],
];
const PATIENCE = 120; // milliseconds that a frame must stay before its particles are asked for

export function mountLayerPanel(app) {
  const { store } = app;
  const boxes = element("div", { class: "checks" });
  const lanes = element("div", { class: "checks" }, LANES.map(({ name, label, unit }) =>
    check(unit ? `${label}, ${unit}` : label, store.state.lanes.has(name), (on) => store.set({ lanes: withOrWithout(store.state.lanes, name, on) }))));
  const panel = element("div", { class: "tabpanel" },
    element("section", { class: "panel" }, element("h2", {}, "Over the film"), boxes),
    element("section", { class: "panel" }, element("h2", {}, "Timeline"), lanes));
  store.on(["shown"], ({ shown }) => fillAnew(boxes, [...shown], () => LAYERS.map(([name, label]) =>
    check(label, shown.has(name), (on) => store.set({ shown: withOrWithout(store.state.shown, name, on) })))));
  let timer = 0;
  store.on(["pictured", "selected", "shown", "playing", "jobs", "connected"], () => {
    clearTimeout(timer);
    timer = setTimeout(() => look(store), PATIENCE);
  });
  return panel;
}

function check(label, checked, onchange) {
  return element("label", { class: "check" },
    element("input", { type: "checkbox", checked, onchange: ({ target }) => onchange(target.checked) }), label);
}

/** Ask the server for the particles of the chosen object, once a frame stands still; an earlier request is given up. */
async function look(store) {
  const { state } = store;
  const { asked, session, pictured: frame, shown } = state;
  const item = selectedItem(state);
  if (!shown.has("particles") || !item?.tracked || state.playing || runningJobs(state).length || frame === null) return;
  if (frame < item.first || frame > item.last || isAbsent(item, frame)) return;
  const key = [session.id, item.object, frame, session.revision].join();
  if (key === asked?.key) return;
  asked?.control.abort();
  const mine = { key, control: new AbortController() };
  store.set({ asked: mine, looked: null }); // the rows may be others now
  try {
    const address = `/api/sessions/${session.id}/overlays/${frame}?object=${item.object}`;
    const looked = await ask(address, { signal: mine.control.signal });
    if (store.state.asked === mine) store.set({ looked });
  } catch (error) {
    if (store.state.asked !== mine) return; // it was given up
    store.set({ asked: null });
    announce(error.message, "error");
  }
}
