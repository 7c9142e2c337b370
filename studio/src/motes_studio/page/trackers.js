// The choice of a tracker: a preset or a configuration file of one's own, and a seed.

import { element, field, fillAnew } from "./dom.js";
import { announce } from "./announce.js";
import { numberTyped } from "./numbers.js";

const OWN = "(own configuration)";
const MORE = "(more)";
const FEW = ["default", "nummiaro"];
let allShown = false; // once somebody has asked for more, menus that are made later have all
const LARGEST = 1 << 16;

/** Return the entries of a menu of presets: few, the chosen one, and one that shows the rest. */
function presetOptions(presets, chosen) {
  const wanted = presets.filter(({ name }) => allShown || FEW.includes(name) || name === chosen);
  const options = wanted.map(({ name, summary }) => element("option", { value: name, title: summary }, name));
  if (!presets.some(({ name }) => name === chosen)) options.push(element("option", { value: chosen }, chosen));
  if (wanted.length < presets.length) options.push(element("option", { value: MORE }, "More …"));
  return options;
}

/** Show all presets in a menu in which "More" was chosen; return whether it was. */
function isMore(menu, presets, chosen) {
  if (menu.value !== MORE) return false;
  allShown = true;
  const rest = [...menu.options].filter(({ value }) => value === OWN);
  menu.replaceChildren(...presetOptions(presets, chosen).filter(({ value }) => value !== OWN), ...rest);
  menu.value = chosen;
  try {
    menu.showPicker();
  } catch {
    // a browser that opens menus by itself alone
  }
  return true;
}

/** Return the fields that choose preset, configuration and seed; `change` is called with what changed. */
export function trackerFields(presets, { preset, config, seed }, change) {
  const options = presetOptions(presets, preset);
  options.push(element("option", { value: OWN }, config === null ? "From a file …" : "Own file"));
  const file = element("input", { type: "file", accept: ".toml", class: "unseen", tabindex: "-1", "aria-label": "Configuration file" });
  file.addEventListener("change", async () => {
    const text = file.files[0] && (await file.files[0].text());
    if (text === undefined || text === null) return;
    if (text.length > LARGEST) announce("A configuration file has at most 64 KB.", "error");
    else change({ config: text });
  });
  const choice = element("select", {
    onchange({ target }) {
      if (isMore(target, presets, config === null ? preset : OWN)) return;
      if (target.value === OWN) {
        target.value = config === null ? preset : OWN;
        file.click();
      } else change({ preset: target.value, config: null });
    },
  }, options);
  choice.value = config === null ? preset : OWN;
  const number = element("input", {
    type: "number", min: "0", max: Number.MAX_SAFE_INTEGER, step: "1", value: seed,
    onchange: ({ target }) => change({ seed: numberTyped(target, seed) }),
  });
  return element("div", { class: "row tracker" }, field("Tracker", choice, { class: "field grow" }), field("Seed", number, { class: "field seed" }), file);
}

/** Return the fields of a choice that is not sent yet; they change it. */
export function trackerChoice(presets, chosen) {
  const place = element("div");
  const paint = () => fillAnew(place, chosen, () => trackerFields(presets, chosen, (changes) => {
    Object.assign(chosen, changes);
    paint();
  }));
  paint();
  return place;
}
