// Elements of the page, made in one call.

const SVG = "http://www.w3.org/2000/svg";

/** Return a new element: properties are attributes, `on...` functions listen, children are nodes or text. */
export function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "value" && tag === "input") made.defaultValue = value;
    else if (name === "value" || name === "checked" || name === "disabled") made[name] = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return made;
}

/** Put the pictures of icons.svg into the page: a reference to another file would flicker. */
export async function loadIcons() {
  const answer = await fetch("/static/icons.svg");
  const { documentElement } = new DOMParser().parseFromString(await answer.text(), "image/svg+xml");
  documentElement.setAttribute("class", "unseen");
  documentElement.setAttribute("aria-hidden", "true");
  document.body.append(documentElement);
}

/** Return one picture of icons.svg; it is hidden from screen readers. */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS(SVG, "use");
  use.setAttribute("href", `#icon-${name}`);
  svg.append(use);
  return svg;
}

/** Show another picture and label on a button. */
export function relabel(made, label, picture, shown = label) {
  made.querySelector("use").setAttribute("href", `#icon-${picture}`);
  made.title = shown;
  made.setAttribute("aria-label", label);
}

/** Return a button with an icon, a label for screen readers and tooltips, or both. */
export function button(label, onclick, { picture = null, text = null, ...properties } = {}) {
  const parts = [picture && icon(picture), text].filter(Boolean);
  const shown = parts.length ? parts : [label];
  const titled = parts.length && text !== label ? { "aria-label": label, title: label } : {};
  return element("button", { type: "button", onclick, ...titled, ...properties }, ...shown);
}

/** Return a labelled field: the label stands before or above its control. */
export function field(label, control, properties = {}) {
  return element("label", { class: "field", ...properties }, element("span", {}, label), control);
}

/** Return a part of the page in which Enter in a field presses the main button. */
export function form(...children) {
  return element("div", { onkeydown(event) {
    const { key, target, currentTarget } = event;
    const main = currentTarget.querySelector("button.main");
    if (key !== "Enter" || !main || !target.matches("input:not([type=file]), select")) return;
    event.preventDefault(); // a menu would open
    main.click();
  } }, ...children);
}

/** Replace what is in a parent; nothing is touched where the nodes are the same. */
export function fill(parent, ...children) {
  parent.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
}

const CONTROLS = "input, select, button";
const late = new Map(); // what a parent is to show, once nothing in it is typed or pressed any more

/**
 * Replace what is in a parent if what it shows has changed. The focus stays at its place. A field that is typed in, or a
 * button that is pressed, is not replaced: this waits until the focus leaves it, or it is released.
 */
export function fillAnew(parent, shown, make) {
  const key = JSON.stringify(shown);
  late.delete(parent);
  if (parent.dataset.key === key) return;
  const controls = () => [...parent.querySelectorAll(CONTROLS)];
  const before = controls();
  const at = before.indexOf(document.activeElement);
  if (isTyped(before[at]) || parent.matches(":active")) {
    late.set(parent, [shown, make]);
    return;
  }
  if (parent.dataset.key === undefined) parent.addEventListener("change", taken);
  parent.dataset.key = key;
  fill(parent, make());
  const after = controls();
  if (at >= 0 && after.length === before.length) after[at].focus();
}

function fillLate() {
  for (const [parent, waiting] of [...late]) fillAnew(parent, ...waiting);
}
for (const end of ["focusout", "pointerup", "pointercancel", "keyup"]) {
  addEventListener(end, () => late.size && setTimeout(fillLate)); // after the click that belongs to it
}

/** Return whether a control is a field in which something was typed that has not been taken yet. */
const isTyped = (control) =>
  control?.tagName === "INPUT" && ["text", "number"].includes(control.type) && control.value !== control.defaultValue;

/** What was typed has been taken: a field may be replaced again. */
const taken = ({ target }) => (target.defaultValue = target.value);

/** Return a canvas's context, its size set to its place on the page in device pixels. */
export function sized(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
  const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/** Call act(x) where a pointer is pressed or dragged on a canvas. */
export function scrub(canvas, act) {
  canvas.addEventListener("pointerdown", ({ pointerId, offsetX }) => {
    canvas.setPointerCapture(pointerId);
    act(offsetX);
  });
  canvas.addEventListener("pointermove", ({ buttons, offsetX }) => buttons && act(offsetX));
}

/** Return a function that draws soon, but not again before a pause in milliseconds: what changes with each frame of a run. */
export function calm(draw, pause = 100) {
  let [timer, drawn] = [0, -Infinity];
  return () => {
    if (timer) return;
    timer = setTimeout(() => {
      timer = 0;
      drawn = performance.now();
      draw();
    }, Math.max(0, drawn + pause - performance.now()));
  };
}

/** Return how large the text of the page is, next to that of a small window: 1 or more. */
export const textScale = () => parseFloat(getComputedStyle(document.documentElement).fontSize) / 13;

const colors = new Map();

/** Return the value of a color of style.css, such as "--line". */
export function color(name) {
  if (!colors.has(name)) {
    colors.set(name, getComputedStyle(document.documentElement).getPropertyValue(name).trim());
  }
  return colors.get(name);
}

/** Read the colors again: the theme has changed. */
export const forgetColors = () => colors.clear();
