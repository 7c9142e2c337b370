// The choice of a tracker: a preset, or a configuration file of one's own, and a seed.

import { element, field } from "./dom.js";
import { announce } from "./announce.js";

const OWN = "(own configuration)";
const LARGEST = 1 << 16;

/** Return the fields that choose preset, configuration and seed; `change` is called with what changed. */
export function trackerFields({ store }, { preset, config, seed }, change) {
  const presets = store.state.presets?.track ?? [];
  const known = presets.some(({ name }) => name === preset);
  const options = presets.map(({ name, summary }) => element("option", { value: name, title: summary }, name));
  if (!known) options.push(element("option", { value: preset }, preset));
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
      if (target.value === OWN) {
        target.value = config === null ? preset : OWN;
        file.click();
      } else change({ preset: target.value, config: null });
    },
  }, options);
  choice.value = config === null ? preset : OWN;
  const number = element("input", {
    type: "number", min: "0", step: "1", value: seed,
    onchange: ({ target }) => change({ seed: Math.max(0, Math.round(Number(target.value))) }),
  });
  return [element("div", { class: "row tracker" }, field("Tracker", choice, { class: "field grow" }), field("Seed", number, { class: "field seed" }), file)];
}
