// The doubtful frames of the chosen object, the first to correct first.

import { button, element, fillAnew } from "./dom.js";
import { clock, rowOf, runningJobs, selectedItem } from "./derived.js";

export function mountDoubtPanel({ store, actions }) {
  const list = element("ol", { class: "doubts" });
  const empty = element("p", { class: "muted" });
  const ask = button("Find doubtful frames", () => actions.findDoubts(), { class: "plain" });
  const panel = element("div", { class: "tabpanel" },
    element("section", { class: "panel" }, element("h2", {}, "Doubtful frames"),
      element("p", { class: "muted" }, "Correct the first one: it makes the most frames right."), list, empty, ask));
  store.on(["doubts", "selected", "frame", "film", "session"], (state) => {
    const items = state.doubts.get(state.selected);
    const item = selectedItem(state);
    ask.disabled = !item?.tracked;
    empty.textContent = !item?.tracked ? "Track an object first." : items && !items.length ? "No frame is in doubt." : "";
    empty.hidden = !empty.textContent;
    const entries = () => (items ?? []).map((doubt) => entry(doubt, state, actions));
    fillAnew(list, [items, state.frame, state.film?.fps], entries);
  });
  let listed = null;
  store.on(["session", "jobs"], (state) => { // what was corrected is tracked again: other frames are in doubt
    const { session, selected, doubts } = state;
    const now = session && [session.id, selected, session.revision].join();
    if (now === listed || !doubts.has(selected) || runningJobs(state).length) return;
    listed = now;
    actions.findDoubts();
  });
  return panel;
}

function entry(doubt, state, actions) {
  const { film, frame, selected } = state;
  const { frame: at, gain, reasons } = doubt;
  return element("li", {},
    element("button", { type: "button", class: "doubt", "aria-current": at === frame ? "true" : null, onclick: () => actions.goToDoubt(doubt) },
      element("span", { class: "at" }, `Frame ${at}`),
      element("span", { class: "muted" }, clock(rowOf(state, selected, at)?.time ?? at / film.fps)),
      element("span", { class: "gain" }, `${gain.toFixed(1)} frames`),
      element("span", { class: "why muted" }, reasons.join(", "))));
}
