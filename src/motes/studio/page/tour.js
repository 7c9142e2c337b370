// The tour: five steps, each beside the part of the page that it explains.

import { button, element } from "./dom.js";
import { openSample } from "./home.js";

const KEY = "motes.toured";
const STEPS = [
  ["#stages", "1. Draw", "Choose the box or the ellipse above the film and drag it over an object. Handles change it; B and E choose the tools."],
  ["#left", "2. Track", "Every object has a name, a color and a tracker. Press Track: rows and particles arrive while it runs."],
  ["#timeline", "3. Look", "The timeline shows status, confidence, size and speed of every frame. Click to go there."],
  ["#transport", "4. Correct", "Press N for the next doubtful frame and drag the ellipse where it belongs. Only the stretch around it is tracked again."],
  ["#actions", "5. Take home", "Export rows, annotations, a film or the command line that makes the same rows. All you do is kept; undo works after a restart too."],
];

export const isToured = () => localStorage.getItem(KEY) !== null;

/** Begin the tour; it needs a session, and waits for one on the first page. */
export function startTour(app) {
  if (!app.store.state.session) {
    localStorage.removeItem(KEY);
    openSample(app);
    return;
  }
  document.querySelector(".tour")?.close();
  let at = 0;
  const title = element("h2", { id: "tour-title" });
  const words = element("p", {});
  const next = button("Next", () => go(at + 1), { class: "main" });
  const back = button("Back", () => go(at - 1), { class: "plain" });
  const dots = element("span", { class: "grow muted" });
  const card = element("dialog", { class: "tour", "aria-labelledby": "tour-title" }, title, words,
    element("div", { class: "row" }, dots, button("End the tour", () => card.close(), { text: "End", class: "plain" }), back, next));
  card.addEventListener("close", () => {
    localStorage.setItem(KEY, "yes");
    document.querySelector(".toured")?.classList.remove("toured");
    card.remove();
  });
  document.body.append(card);
  card.showModal();
  go(0);

  function go(step) {
    if (step >= STEPS.length) {
      card.close();
      return;
    }
    at = Math.max(0, step);
    const [place, heading, text] = STEPS[at];
    title.textContent = heading;
    words.textContent = text;
    dots.textContent = `${at + 1} of ${STEPS.length}`;
    back.disabled = at === 0;
    next.textContent = at === STEPS.length - 1 ? "Begin" : "Next";
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
  let [x, y] = [part.left + (part.width - width) / 2, part.top + (part.height - height) / 2];
  if (below) y = part.bottom + gap;
  else if (right && part.width < innerWidth / 2) x = part.right + gap;
  else if (above) y = part.top - gap - height;
  card.style.left = `${Math.min(innerWidth - width - gap, Math.max(gap, x))}px`;
  card.style.top = `${Math.min(innerHeight - height - gap, Math.max(gap, y))}px`;
}
