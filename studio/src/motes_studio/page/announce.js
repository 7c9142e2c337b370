// Short messages: for all in a corner, for screen readers through a live region.

import { button, element } from "./dom.js";

const SECONDS = { note: 4, error: 12 };
const LETTERS = 15; // that are read in a second

/** Show a message; a long one and an error stay longer, and an error is read at once. Return a function that takes it away. */
export function announce(text, kind = "note") {
  const region = document.getElementById(kind === "error" ? "alerts" : "notes");
  const close = button("Close this message", () => message.remove(), { picture: "close" });
  const message = element("div", { class: `message ${kind}` }, element("span", {}, text), close);
  region.append(message);
  [...region.querySelectorAll(".message:not(.ongoing)")].slice(0, -3).forEach((old) => old.remove());
  setTimeout(() => message.remove(), (SECONDS[kind] + text.length / LETTERS) * 1000);
  return () => message.remove();
}

/** Show how far something is, until its end: return functions that take its share so far, and that end it. */
export function ongoing(text) {
  const bar = element("progress", { max: "1", value: 0, "aria-label": text });
  const message = element("div", { class: "message note ongoing" }, element("span", {}, text), bar);
  document.getElementById("notes").append(message);
  return [(share) => (bar.value = share), () => message.remove()];
}

/** Show why something failed; what comes soon by itself is no error. */
export function explain({ message, soon }, words = "") {
  if (soon) announce(message);
  else announce(words + message, "error");
}

/** Return what a promise brings, or null after showing why it failed. */
export async function tried(promise, words = "") {
  try {
    return await promise;
  } catch (error) {
    explain(error, words);
    return null;
  }
}

/** Have screen readers read a text; nothing is shown. */
export function read(text) {
  document.getElementById("spoken").textContent = text;
}
