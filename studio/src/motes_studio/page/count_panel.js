// The many-object mode: track all that moves, count it, and show it over time.

import { button, element, field, fill, fillAnew, form } from "./dom.js";
import { numbersIn, numberTyped } from "./numbers.js";
import { endGround } from "./places.js";
import { trackerChoice } from "./trackers.js";

const DETECTORS = [
  ["background", "Motion"],
  ["people", "People"],
  ["faces", "Faces"],
];
const LATEST = 8; // events that are listed

export function mountCountPanel(app) {
  const { store, actions } = app;
  const detector = element("select", {}, DETECTORS.map(([value, label]) => element("option", { value }, label)));
  const chosen = { preset: "nummiaro:adaptive", config: null, seed: 0 };
  const tracker = element("div");
  const start = button("Track all that moves", () => actions.watch({ detector: detector.value, ...chosen }),
    { class: "main grow", picture: "play", text: "Track all that moves" });
  const counts = element("div", { "aria-live": "polite" });
  const events = element("ol", { class: "events" });
  const panel = element("div", { class: "tabpanel" },
    element("section", { class: "panel" }, element("h2", {}, "All that moves"),
      field("Detector", detector), tracker, element("div", { class: "row" }, start)),
    element("section", { class: "panel" }, element("h2", {}, "Lines, zones and ground"), mountPlaces(app)),
    element("section", { class: "panel" }, element("h2", {}, "Counts"), counts, events));
  store.on(["presets"], ({ presets }) => presets && fill(tracker, trackerChoice(presets.watch, chosen)));
  store.on(["counts"], (state) => fill(counts, countRows(state)));
  store.on(["events"], (state) => fillAnew(events, state.events.slice(-LATEST), () => eventRows(app, state)));
  return panel;
}

function countRows({ counts }) {
  if (!counts) return element("p", { class: "muted" }, "Draw a line or a zone, then track all that moves.");
  const rows = [["Objects now", counts.objects], ...Object.entries(counts.totals)];
  return element("table", {}, element("tbody", {}, rows.map(([name, value]) =>
    element("tr", {}, element("th", { scope: "row" }, name), element("td", { class: "number" }, value)))));
}

function eventRows({ player }, { events }) {
  return events.slice(-LATEST).reverse().map((event) => {
    const { frame, id, event: what, direction, place } = event;
    const words = [id, what, place, direction].filter((word) => word !== undefined && word !== null);
    return element("li", {}, button(`Go to frame ${frame}`, () => player.go(frame), { text: `${frame}: ${words.join(" ")}`, class: "event" }));
  });
}

/** The buttons of the tools, what each line and zone is called, and the ground. */
function mountPlaces(app) {
  const { store, actions } = app;
  const tools = element("div", { class: "row even" });
  const entries = element("div", { class: "stack" });
  const ground = element("div", { class: "row" });
  store.on(["tool"], ({ tool }) => fillAnew(tools, tool, () => ["line", "zone", "ground"].map((name) =>
    button(name, () => actions.choose(name), {
      picture: name, text: name[0].toUpperCase() + name.slice(1), class: "plain", "aria-pressed": String(tool === name),
    }))));
  store.on(["session"], ({ session }) => session && paintEntries(entries, actions, session.places));
  store.on(["session", "corners"], ({ session, corners }) => {
    const count = corners.length ? 0 : session?.places.ground?.length ?? 0;
    fillAnew(ground, count, () => (count
      ? [element("span", { class: "grow" }, `Ground: ${count} points`),
        button("Remove the ground", () => actions.setPlaces(() => ({ ground: null })), { picture: "trash" })]
      : []));
  });
  return element("div", { class: "places" }, tools, entries, mountGroundForm(app), ground);
}

/** The lines and zones, drawn anew only when they have changed: a name that is half typed stays. */
function paintEntries(root, actions, { lines, zones }) {
  const entry = (kind, list, at) => {
    const place = list[at];
    const change = (next) => actions.setPlaces(({ [kind]: now }) => ({
      [kind]: now.map((old, other) => (other === at ? { ...old, ...next } : old)),
    }));
    const usual = `${kind.slice(0, -1)} ${at + 1}`;
    const name = element("input", {
      value: place.name, placeholder: usual, "aria-label": `Name of ${usual}`, maxlength: "100",
      onchange: ({ target }) => change({ name: target.value }),
    });
    const rest = kind === "lines" ? sides(place, usual, change) : stay(place, usual, change);
    const remove = button(`Remove ${usual}`, () => actions.setPlaces(({ [kind]: now }) => ({ [kind]: now.filter((_, other) => other !== at) })), { picture: "trash" });
    return element("div", { class: "stack" }, element("div", { class: "row" }, name, remove), rest);
  };
  fillAnew(root, [lines, zones], () =>
    [lines.map((_, at) => entry("lines", lines, at)), zones.map((_, at) => entry("zones", zones, at))]);
}

/** The names of the two directions in which a line is crossed: to its left, where the stroke points, and back. */
function sides(line, usual, change) {
  const side = (at, word) => element("input", {
    value: line.label[at], maxlength: "100", "aria-label": `Name of crossings of ${usual} ${at ? "against" : "along"} the stroke`,
    onchange({ target }) {
      const label = [...line.label];
      label[at] = target.value || word;
      change({ label });
    },
  });
  return element("div", { class: "row even" }, side(0, "in"), side(1, "out"));
}

/** The seconds after which an object stays in a zone. */
function stay(zone, usual, change) {
  const seconds = element("input", {
    type: "number", min: "0", step: "any", value: zone.dwell ?? "", placeholder: "seconds of a stay",
    "aria-label": `Seconds of a stay in ${usual}`,
    onchange: ({ target }) => change({ dwell: (target.value && numberTyped(target, zone.dwell ?? "")) || null }),
  });
  return element("div", { class: "row" }, seconds);
}

/** The places in metres of the points that were clicked: what was typed stays when points are added. */
function mountGroundForm(app) {
  const rows = element("div", { class: "stack" });
  const send = () => {
    const typed = numbersIn([...rows.querySelectorAll("input")]);
    if (typed) endGround(app, typed);
  };
  const set = button("Set the ground", send, { class: "main", text: "Set the ground" });
  const metres = form(element("fieldset", { class: "ground" },
    element("legend", { class: "muted" }, "Metres of each point: X, Y"), rows, set));
  app.store.on(["corners", "tool"], ({ corners, tool }) => {
    const count = tool === "ground" ? corners.length : 0;
    while (rows.children.length > count) rows.lastChild.remove();
    while (rows.children.length < count) rows.append(groundPoint(rows.children.length));
    metres.hidden = count === 0;
    set.disabled = count < 4;
  });
  return metres;
}

/** The place in metres of one point, which only the user knows. */
function groundPoint(at) {
  const input = (label) => element("input", { type: "number", step: "any", required: true, "aria-label": label });
  return element("div", { class: "row even" },
    element("span", {}, `Point ${at + 1}`), input(`X of point ${at + 1}`), input(`Y of point ${at + 1}`));
}
