// The list of objects, and what can be done with the chosen one.

import { button, element, field, fillAnew, icon } from "./dom.js";
import { COLORS, dashes } from "./colors.js";
import { plural, isAbsent, keyframeOf, rowOf, selectedItem, shown, withOrWithout } from "./derived.js";
import { trackerFields } from "./trackers.js";

const SVG = "http://www.w3.org/2000/svg";

export function mountObjects(root, app) {
  const { store } = app;
  const list = element("ul", { class: "objects", "aria-label": "Objects" });
  const [given, corrected] = [element("div", { class: "chosen" }), element("div", { class: "chosen" })];
  const add = button("New object", () => app.actions.choose("box"), { picture: "plus", text: "New" });
  root.append(
    element("section", { class: "panel" }, element("header", {}, element("h2", {}, "Objects"), add), list),
    given, corrected,
  );
  store.on(["session", "selected", "hidden", "looks"], ({ session, selected, hidden, looks }) => {
    if (session) fillAnew(list, [session.objects, selected, [...hidden], looks], () => entries(app));
  });
  store.on(["rows", "pictured", "session"], (state) => state.session && updateNumbers(list, state));
  store.on(["session", "selected", "presets", "pictured"], (state) => {
    const item = selectedItem(state);
    const { object, name, color, preset, config, seed, tracked } = item ?? {};
    const facts = [object, name, color, preset, config, seed, tracked, state.presets];
    fillAnew(given, facts, () => (item ? [settings(app, item)] : []));
    const around = item && [item, state.session.objects, state.session.effort, here(state, item)];
    fillAnew(corrected, around, () => (item ? [corrections(app, item)] : []));
  });
}

function entries(app) {
  const { store } = app;
  const { session, selected, hidden } = store.state;
  if (!session.objects.length) {
    return [element("li", { class: "empty muted" }, "Draw a box or an ellipse around an object.")];
  }
  return session.objects.map((item, place) => {
    const seen = !hidden.has(item.object);
    const choose = element(
      "button",
      {
        type: "button", class: "object grow", "aria-pressed": String(item.object === selected),
        onclick: () => pick(app, item),
      },
      swatch(item.color, dashes(place)),
      element("span", { class: "grow name" }, item.name),
      element("span", { class: "value muted", "data-object": item.object }),
    );
    const toggle = button(`${seen ? "Hide" : "Show"} ${item.name}`,
      () => store.set({ hidden: withOrWithout(hidden, item.object, seen) }),
      { picture: seen ? "eye" : "hidden", "aria-pressed": String(!seen) });
    return element("li", {}, choose, toggle);
  });
}

/** Choose an object; where nothing of it is known, the film goes to its first keyframe. */
function pick({ store, player }, item) {
  const { frame } = store.state;
  store.set({ selected: item.object });
  const rows = store.state.rows.get(item.object) ?? [];
  if (!rows[frame] && !keyframeOf(item, frame) && item.keyframes.length) player.go(item.keyframes[0].frame);
}

function swatch(color, dash) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("viewBox", "0 0 24 14");
  svg.setAttribute("aria-hidden", "true");
  const ring = document.createElementNS(SVG, "ellipse");
  const shape = { cx: 12, cy: 7, rx: 10, ry: 5, fill: "none", stroke: color, "stroke-width": 2.4, "stroke-dasharray": dash.map((length) => length / 1.6).join(" ") };
  for (const [name, value] of Object.entries(shape)) ring.setAttribute(name, value);
  svg.append(ring);
  return svg;
}

function updateNumbers(list, state) {
  for (const place of list.querySelectorAll("[data-object]")) {
    const item = state.session.objects.find(({ object }) => object === Number(place.dataset.object));
    if (!item) continue;
    const row = rowOf(state, item.object, state.pictured);
    const drawn = keyframeOf(item, state.pictured);
    place.textContent = drawn ? "◆" : isAbsent(item, state.pictured) ? "absent" : row ? shown(row.confidence) : "–";
  }
}

const here = (state, item) => [Boolean(keyframeOf(item, state.pictured)), isAbsent(item, state.pictured)];

function settings(app, item) {
  const { actions } = app;
  const change = (changes) => actions.change(item.object, changes);
  const name = element("input", {
    value: item.name, maxlength: "100", async onchange({ target }) {
      if (!(await change({ name: target.value }))) target.value = item.name;
    },
  });
  const colors = element("div", { class: "colors", role: "radiogroup", "aria-label": "Color" },
    COLORS.map(({ name: title, value }) => {
      const radio = element("input", {
        type: "radio", name: "color", class: `color ${title.replace(" ", "-")}`, "aria-label": title, title,
        checked: value === item.color, onchange: () => change({ color: value }),
      });
      radio.style.color = value;
      return radio;
    }));
  const track = button("Track", () => actions.track([item.object]), {
    picture: "play", text: item.tracked ? "Track again" : "Track", class: "main grow", id: "track",
  });
  return element("section", { class: "panel" },
    element("header", {}, element("h2", {}, item.name), button(`Remove ${item.name}`, () => actions.remove(), { picture: "trash" })),
    field("Name", name), colors,
    trackerFields(app.store.state.presets?.track ?? [], item, change),
    item.tracked ? element("p", { class: "muted" }, "Another tracker or seed drops the rows; undo brings them back.") : null,
    element("div", { class: "row" }, track));
}

function corrections(app, item) {
  const { store, actions, dialogs } = app;
  const [drawn, absent] = here(store.state, item);
  const action = (label, key, picture, act, properties = {}) =>
    element("button", { type: "button", class: "plain action", onclick: act, "aria-keyshortcuts": key, ...properties },
      icon(picture), element("span", { class: "grow" }, label), element("kbd", {}, key));
  const others = store.state.session.objects.filter(({ object }) => object !== item.object);
  const join = element("select", {
    "aria-label": "Join with",
    onchange: ({ target }) => target.value && actions.join(Number(target.value)),
  }, element("option", { value: "" }, "Join with …"),
  others.map(({ object, name }) => element("option", { value: object }, name)));
  return element("section", { class: "panel" },
    element("header", {}, element("h2", {}, "Correct this frame")),
    element("div", { class: "actions" },
      action(drawn ? "Remove keyframe" : "Keyframe", "K", "key", () => actions.toggleKeyframe(), { "aria-pressed": String(drawn) }),
      action("Absent", "A", "absent", () => actions.toggleAbsent(), { "aria-pressed": String(absent) }),
      action("Draw again", "R", "box", () => actions.redraw()),
      action("Split here", "S", "split", () => actions.split()),
      action("Next doubtful", "N", "doubt", () => actions.nextDoubt())),
    element("div", { class: "stack" },
      button("Absent from … to …", () => dialogs.absent(), { class: "plain" }), others.length ? join : null),
    item.imported
      ? element("p", { class: "muted" }, "Its rows are from a file. A keyframe has those up to its neighbors tracked again; undo brings them back.")
      : null,
    element("p", { class: "effort muted" }, effort(store.state.session, item)));
}

function effort(session, item) {
  return `${plural(item.corrections, "correction")} of ${item.name}; ${shown(session.effort, 1)} for each 100 frames in all`;
}
