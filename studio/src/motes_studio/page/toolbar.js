// The tools over the stage, and the player under it.

import { button, element, relabel } from "./dom.js";
import { clock, plural, runningJobs, timeOf } from "./derived.js";

const TOOLS = [
  ["select", "Choose and move (V)", "select"],
  ["box", "Draw a box (B)", "box"],
  ["ellipse", "Draw an ellipse (E)", "ellipse"],
  ["hand", "Move the picture (H)", "hand"],
  null,
  ["line", "Draw a line that is counted", "line"],
  ["zone", "Draw a zone that is counted", "zone"],
  ["ground", "Click four points of the ground", "ground"],
];

export function mountTools(root, app) {
  const { store } = app;
  const buttons = new Map();
  for (const entry of TOOLS) {
    if (!entry) {
      root.append(element("span", { class: "divider", "aria-hidden": "true" }));
      continue;
    }
    const [name, label, picture] = entry;
    const made = button(label, () => app.actions.choose(name), { picture });
    buttons.set(name, made);
    root.append(made);
  }
  const share = element("span", { class: "zoom muted", "aria-live": "off" });
  root.append(
    element("span", { class: "grow" }), jobView(app), element("span", { class: "divider", "aria-hidden": "true" }),
    button("Zoom out (-)", () => app.zoom("-"), { picture: "minus" }), share,
    button("Zoom in (+)", () => app.zoom("+"), { picture: "plus" }),
    button("Whole film (0)", () => app.zoom("0"), { picture: "fit" }));
  store.on(["tool"], ({ tool }) => {
    for (const [name, made] of buttons) made.setAttribute("aria-pressed", String(name === tool));
  });
  store.on(["view", "film", "sized"], () => {
    share.textContent = `${Math.round(100 * (app.viewNow()?.scale ?? 1))} %`;
  });
}

/** The run that is going on: its share, rate, time left, and stop. */
function jobView({ store, actions }) {
  const bar = element("progress", { max: "1", "aria-label": "Progress" });
  const words = element("span", { class: "words" });
  const view = element("div", { class: "job row" }, bar, words, button("Stop", () => actions.stop(), { picture: "stop" }));
  store.on(["jobs"], (state) => {
    const [job] = runningJobs(state);
    view.hidden = !job;
    if (!job) return;
    bar.value = job.total ? job.done / job.total : 0;
    words.textContent = wordsOf(job, bar.value);
  });
  return view;
}

function wordsOf({ status, rate, left }, share) {
  const state = status === "waiting" ? "Waiting" : `${Math.floor(100 * share)} %`;
  const speed = rate === null ? "" : `${plural(Math.round(rate), "frame")}/s`;
  const rest = left === null ? "" : `${clock(Math.ceil(left))} left`;
  return [state, speed, rest].filter(Boolean).join(" · ");
}

export function mountTransport(root, app) {
  const { store, player, actions } = app;
  const play = button("Play", () => player.toggle(), { picture: "play", id: "play" });
  const goThere = ({ target }) => {
    if (target.value !== "") player.go(Number(target.value));
    target.value = store.state.frame;
  };
  const number = element("input", {
    type: "number", min: "0", step: "1", class: "frame", "aria-label": "Frame", id: "frame", onchange: goThere,
    onkeydown: (event) => event.key === "Enter" && goThere(event), // also where the number is the same
  });
  const total = element("span", { class: "muted" });
  const time = element("span", { class: "muted time" });
  const speed = element("select", {
    "aria-label": "Speed", class: "speed", onchange: ({ target }) => {
      store.set({ speed: Number(target.value), playing: false });
    },
  }, [0.1, 0.25, 0.5, 1, 2, 4].map((value) => element("option", { value }, `${value}×`)));
  speed.value = "1";
  const follow = element("input", {
    type: "checkbox", onchange: ({ target }) => store.set({ following: target.checked, playing: false }),
  });
  root.append(
    button("First frame (Home)", () => player.go(0), { picture: "first" }),
    button("One frame back (D)", () => player.step(-1), { picture: "back" }), play,
    button("One frame forward (F)", () => player.step(1), { picture: "forward" }),
    button("Last frame (End)", () => player.go(Infinity), { picture: "last" }),
    number, total, time, speed,
    element("label", { class: "check" }, follow, "Follow the run"),
    element("span", { class: "grow" }),
    button("Next doubtful frame (N)", () => actions.nextDoubt(), { picture: "doubt", text: "Next doubtful", class: "plain" }));
  store.on(["playing"], ({ playing }) => {
    const word = playing ? "Pause" : "Play";
    relabel(play, word, word.toLowerCase(), `${word} (Space)`);
  });
  store.on(["following"], ({ following }) => (follow.checked = following));
  store.on(["frame", "film", "times"], (state) => {
    const { frame, film } = state;
    if (!film) return;
    if (document.activeElement !== number) number.value = frame;
    number.max = film.frames - 1;
    total.textContent = `of ${film.frames - 1}`;
    time.textContent = `${clock(timeOf(state, frame))} / ${clock(timeOf(state, film.frames - 1))}`;
  });
}
