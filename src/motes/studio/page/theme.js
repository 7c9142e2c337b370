// Light and dark: as the system has it, or as the person chose.

import { forgetColors } from "./dom.js";

const KEY = "motes.theme";
const ORDER = ["system", "light", "dark"];

export function startTheme(store) {
  store.set({ theme: localStorage.getItem(KEY) ?? "system" });
  const system = matchMedia("(prefers-color-scheme: dark)");
  const show = () => {
    const { theme } = store.state;
    const dark = theme === "dark" || (theme === "system" && system.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    forgetColors();
    store.touch("looks");
  };
  system.addEventListener("change", show);
  store.on(["theme"], show);
}

/** Choose the next of system, light and dark. */
export function switchTheme(store) {
  const theme = ORDER[(ORDER.indexOf(store.state.theme) + 1) % ORDER.length];
  localStorage.setItem(KEY, theme);
  store.set({ theme });
  return theme;
}
