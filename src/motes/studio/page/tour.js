// The tour: five steps, each beside the part of the page that it explains.

import { button, element } from "./dom.js";
import { openSample } from "./home.js";

let due = false;
const newest = ({ session }) => session?.objects.at(-1);
/** The steps: the part of the page, what to do there, and how it shows that it was done. */
const STEPS = [
  { place: "#stages", title: "1. Draw", begin: (app) => newest(app.store.state) || app.actions.choose("box"),
    text: "Drag a box around an object, as the beetle of the sample film: from one corner to the opposite one. Handles change it; B and E choose box and ellipse.",
    done: (state) => newest(state) && `${newest(state).name} is drawn, and in the list on the left.` },
  { place: "#left", title: "2. Track",
    text: "Every object has a name, a color and a tracker. Press Track: rows and particles arrive while it runs.",
    done: ({ session, jobs }) => (session?.objects.some(({ tracked }) => tracked) && "It is tracked: play the film to see it.")
      || ([...jobs.values()].length > 0 && "It is being tracked.") },
  { place: "#timeline", title: "3. Look",
    text: "The timeline shows status, confidence, size and speed of every frame. Click to go there.",
    done: ({ frame }, { frame: before }) => frame !== before && `This is frame ${frame}.` },
  { place: "#transport", title: "4. Correct",
    text: "Press N for the next doubtful frame and drag the ellipse where it belongs. Only the stretch around it is tracked again.",
    done: (state) => newest(state)?.keyframes.length > 1 && "It is corrected here." },
  { place: "#actions", title: "5. Take home",
    text: "Export rows, annotations, a film or the command line that makes the same rows. All you do is kept; undo works after a restart too.",
    done: () => null },
];

/** Whether a tour waits for a session. */
export const isDue = () => due;

/** Begin the tour; it needs a session, and waits for one on the first page. */
export function startTour(app) {
  if (!app.store.state.session) {
    due = true;
    openSample(app);
    return;
  }
  due = false;
  document.querySelector(".tour")?.close();
  let [at, before] = [0, app.store.state];
  const title = element("h2", { id: "tour-title" });
  const words = element("p", {});
  const done = element("p", { class: "good", role: "status" });
  const next = button("Next", () => go(at + 1), { class: "main" });
  const back = button("Back", () => go(at - 1), { class: "plain" });
  const dots = element("span", { class: "grow muted" });
  const card = element("dialog", { class: "tour", "aria-labelledby": "tour-title" }, title, words, done,
    element("div", { class: "row" }, dots, button("End the tour", () => card.close(), { text: "End", class: "plain" }), back, next));
  const off = app.store.on(["session", "jobs", "frame", "film"], look);
  card.addEventListener("keydown", (event) => event.key === "Escape" && card.close());
  card.addEventListener("close", () => {
    off();
    document.querySelector(".toured")?.classList.remove("toured");
    card.remove();
  });
  document.body.append(card);
  card.show(); // not as a modal dialog: the page is used while the card explains it
  go(0);

  /** Show that the person has done what the step speaks of. */
  function look(state) {
    if (!state.session) card.close();
    const found = STEPS[at].done(state, before);
    done.textContent = found ? `✓ ${found}` : "";
  }

  function go(step) {
    if (step >= STEPS.length) {
      card.close();
      return;
    }
    at = Math.max(0, step);
    const { place, title: heading, text, begin } = STEPS[at];
    before = { frame: app.store.state.frame };
    begin?.(app);
    title.textContent = heading;
    words.textContent = text;
    dots.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    next.textContent = at === STEPS.length - 1 ? "Begin" : "Next";
    look(app.store.state);
    document.querySelector(".toured")?.classList.remove("toured");
    const part = document.querySelector(place);
    part.classList.add("toured");
    beside(card, part.getBoundingClientRect());
    next.focus();
  }
}

/** Put the card beside a part of the page, inside the window. */
function beside(card, part) {
  const gap = 16;
  const { width, height } = card.getBoundingClientRect();
  const below = part.bottom + gap + height < innerHeight;
  const right = part.right + gap + width < innerWidth;
  const above = part.top - gap - height > 0;
  let [x, y] = [part.right - width - gap, part.bottom - height - gap]; // of a large part: its corner
  if (below) y = part.bottom + gap;
  else if (right && part.width < innerWidth / 2) x = part.right + gap;
  else if (above) y = part.top - gap - height;
  card.style.left = `${Math.min(innerWidth - width - gap, Math.max(gap, x))}px`;
  card.style.top = `${Math.min(innerHeight - height - gap, Math.max(gap, y))}px`;
}
