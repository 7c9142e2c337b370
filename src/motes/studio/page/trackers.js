// The choice of a tracker: a preset, or a configuration file of one's own, a seed, and a trained network.

import { element, field } from "./dom.js";
import { announce } from "./announce.js";
import { ask, sendNetwork } from "./api.js";

const OWN = "(own configuration)";
const MORE = "(more)";
const FEW = ["default", "nummiaro"];
let allShown = false; // once somebody has asked for more, menus that are made later have all
const LARGEST = 1 << 16;
const KEY = "motes.network";

/** Return the entries of a menu of presets: few, the chosen one, and one that shows the rest. */
export function presetOptions(presets, chosen) {
  const wanted = presets.filter(({ name }) => allShown || FEW.includes(name) || name === chosen);
  const options = wanted.map(({ name, summary }) => element("option", { value: name, title: summary }, name));
  if (!presets.some(({ name }) => name === chosen)) options.push(element("option", { value: chosen }, chosen));
  if (wanted.length < presets.length) options.push(element("option", { value: MORE }, "More …"));
  return options;
}

/** Show all presets in a menu in which "More" was chosen; return whether it was. */
export function isMore(menu, presets, chosen) {
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
export function trackerFields({ store }, { preset, config, seed, network }, change) {
  const presets = store.state.presets?.track ?? [];
  const options = presetOptions(presets, preset);
  options.push(element("option", { value: OWN }, config === null ? "From a file …" : "Own configuration"));
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
      } else {
        const joins = takesNetwork(presets, target.value);
        change({ preset: target.value, config: null, ...(joins ? {} : { network: [] }) });
      }
    },
  }, options);
  choice.value = config === null ? preset : OWN;
  const number = element("input", {
    type: "number", min: "0", step: "1", value: seed,
    onchange: ({ target }) => change({ seed: Math.max(0, Math.round(Number(target.value))) }),
  });
  return [element("div", { class: "row tracker" }, field("Tracker", choice, { class: "field grow" }), field("Seed", number, { class: "field seed" }), file),
    takesNetwork(presets, preset) ? networkField(store, network, change) : null];
}

const takesNetwork = (presets, name) => presets.some((each) => each.name === name && each.network);
const namesOf = (files) => files.map((path) => path.split(/[\\/]/).at(-1)).join(", ");

/** Return the field of the trained network that joins; it is remembered for new objects. */
function networkField(store, network, change) {
  const key = (files) => files.join("\n");
  const known = store.state.networks;
  const all = network.length && !known.some((files) => key(files) === key(network)) ? [...known, network] : known;
  const join = (files) => {
    localStorage.setItem(KEY, JSON.stringify(files));
    store.set({ tracker: { ...store.state.tracker, network: files } });
    change({ network: files });
  };
  const file = element("input", { type: "file", accept: ".onnx,.data", multiple: true, class: "unseen", tabindex: "-1", "aria-label": "Files of a network" });
  file.addEventListener("change", async () => {
    if (!file.files.length) return;
    try {
      const files = await sendNetwork([...file.files]);
      store.set({ networks: await ask("/api/networks") });
      join(files);
    } catch (error) {
      announce(error.message, "error");
    }
  });
  const menu = element("select", {
    onchange({ target }) {
      if (target.value === OWN) {
        target.value = key(network);
        file.click();
      } else join(all.find((files) => key(files) === target.value) ?? []);
    },
  }, [element("option", { value: "" }, "None"),
    ...all.map((files) => element("option", { value: key(files), title: namesOf(files) }, namesOf(files))),
    element("option", { value: OWN }, "From files …")]);
  menu.value = key(network);
  return element("div", { class: "row tracker" }, field("Trained network", menu, { class: "field grow" }), file);
}

/** Let new objects have the network that was chosen last, if the studio still has it. */
export function recallNetwork(store) {
  const chosen = localStorage.getItem(KEY);
  const network = store.state.networks.find((files) => JSON.stringify(files) === chosen);
  if (network) store.set({ tracker: { ...store.state.tracker, network } });
}
