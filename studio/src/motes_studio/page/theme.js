// Light and dark: as the system has it, or as the person chose.

import { forgetColors } from "./dom.js";

const KEY = "motes.theme";
const DARK = matchMedia("(prefers-color-scheme: dark)");

export function startTheme(store) {
  store.set({ theme: localStorage.getItem(KEY) ?? "system" });
  const show = () => {
    const { theme } = store.state;
    const dark = theme === "dark" || (theme === "system" && DARK.matches);
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    forgetColors();
    store.touch("looks");
  };
  DARK.addEventListener("change", show);
  store.on(["theme"], show);
}

/** Choose the next of the system's colors, the other ones, and the same. */
export function switchTheme(store) {
  const order = ["system", ...(DARK.matches ? ["light", "dark"] : ["dark", "light"])];
  const theme = order[(order.indexOf(store.state.theme) + 1) % order.length];
  localStorage.setItem(KEY, theme);
  store.set({ theme });
  return theme;
}
