// The first page: films to open, a place to drop one, and the sessions so far.

import { ask, send } from "./api.js";
import { announce, ongoing, tried } from "./announce.js";
import { plural } from "./derived.js";
import { button, element, fillAnew, icon } from "./dom.js";
import { bring } from "./files.js";

export function mountHome(root, app) {
  const { store } = app;
  const films = element("ul", { class: "films", "aria-label": "Films" });
  const sessions = element("ul", { class: "sessions", "aria-label": "Sessions" });
  const filter = element("input", { type: "search", placeholder: "Find a film", "aria-label": "Find a film", oninput: () => paint() });
  const paint = () => fillAnew(films, [store.state.films, store.state.sessions, filter.value], () => filmEntries(app, filter.value));
  root.append(
    element("div", { class: "intro" },
      element("h1", {}, "See, correct and trust tracks"),
      element("p", { class: "muted" }, "Open a film, draw around an object, watch it being followed, and correct the frames in doubt."),
      button("Open the sample film", () => openSample(app), { class: "plain", picture: "film", text: "Open the sample film" })),
    dropZone(app),
    element("div", { class: "lists" },
      element("section", { class: "card" }, element("header", {}, element("h2", {}, "Films"), filter), films),
      element("section", { class: "card" }, element("header", {}, element("h2", {}, "Sessions")), sessions)));
  store.on(["films", "sessions"], paint);
  store.on(["sessions"], (state) => fillAnew(sessions, state.sessions, () => sessionEntries(app, state)));
}

/** Read the lists again: the person is on the first page. */
export async function refreshHome({ store }) {
  const { presets: known } = store.state;
  const all = Promise.all([ask("/api/films"), ask("/api/sessions"), known ?? ask("/api/presets")]);
  const found = await tried(all, "The server does not answer: ");
  if (!found) return;
  const [films, sessions, presets] = found;
  store.set({ films, sessions, presets });
}

let opening = false;

/** Open the session of a film, or another one, anew; a second click does not open a second one. */
async function openFilm(app, film, uploaded = false, anew = false) {
  if (opening) return;
  opening = true;
  document.body.classList.add("busy");
  const session = await tried(ask("/api/sessions", { method: "POST", body: { film, uploaded, anew } }));
  if (session) location.hash = `#${session.id}`;
  opening = false;
  document.body.classList.remove("busy");
}

/** The films of `motes demo`. */
const SAMPLES = {
  beetle: "An animal hides, turns and grows",
  street: "Cars to count; a lorry hides some",
  player: "A player among others who look alike",
};

/** Open a sample film; the server renders it when it is first asked for. */
async function openSample(app, sample = "beetle") {
  const made = announce("The sample film is made and opened. This takes some seconds …");
  const film = await tried(ask(`/api/samples/${sample}`, { method: "POST" }));
  if (film) await openFilm(app, film.name, true);
  made();
}

function filmEntries(app, words) {
  const { films } = app.store.state;
  if (films === null) return element("li", { class: "muted empty" }, "…");
  const own = films.some(({ name, uploaded }) => !uploaded || !name.startsWith("sample-"));
  if (!own) return [element("li", { class: "muted empty" }, "There is no film in the folder. Drop one above, or try one that is made here:"), ...sampleEntries(app)];
  const found = films.filter(({ name }) => name.toLowerCase().includes(words.toLowerCase()));
  if (!found.length) return element("li", { class: "muted empty" }, "No film has this name.");
  const known = new Set((app.store.state.sessions ?? []).map(({ film }) => film));
  return found.map(({ name, bytes, uploaded }) => element("li", { class: "row" },
    element("button", { type: "button", class: "entry", onclick: () => openFilm(app, name, uploaded) },
      icon("film"), element("span", { class: "grow name", title: name }, name),
      element("span", { class: "muted" }, uploaded ? "uploaded" : ""), element("span", { class: "muted size" }, size(bytes))),
    known.has(name) ? button(`New session of ${name}`, () => openFilm(app, name, uploaded, true), { picture: "plus" }) : null));
}

const sampleEntries = (app) => Object.entries(SAMPLES).map(([name, words]) => element("li", {},
  element("button", { type: "button", class: "entry", onclick: () => openSample(app, name) },
    icon("film"), element("span", { class: "grow name" }, words))));

const size = (bytes) => (bytes > 1e6 ? `${(bytes / 1e6).toFixed(1)} MB` : bytes ? `${Math.ceil(bytes / 1e3)} KB` : "");

function sessionEntries(app, { sessions }) {
  if (sessions === null) return element("li", { class: "muted empty" }, "…");
  if (!sessions.length) return element("li", { class: "muted empty" }, "What you do is kept here, as it happens.");
  return sessions.map(({ id, film, objects, counted, changed }) => element("li", { class: "row" },
    element("a", { href: `#${id}`, class: "entry" },
      element("span", { class: "grow name" }, film),
      element("span", { class: "muted" }, contents(objects, counted)),
      element("time", { class: "muted", datetime: changed }, when(changed))),
    button(`Delete the session of ${film}`, () => app.dialogs.remove(id, film), { picture: "trash" })));
}

function contents(objects, counted) {
  const drawn = objects ? plural(objects, "object") : null;
  return [drawn, counted ? "counted" : null].filter(Boolean).join(", ") || "nothing yet";
}

function when(changed) {
  const date = new Date(/[Z+]/.test(changed.slice(10)) ? changed : `${changed}Z`);
  return Number.isNaN(date.getTime()) ? changed : date.toLocaleString([], { dateStyle: "short", timeStyle: "short" });
}

/** A place for films that are dropped or chosen. What is dropped on any other part of the page is taken, too. */
function dropZone(app) {
  const file = element("input", { type: "file", class: "unseen", id: "file", onchange({ target }) {
    if (target.files[0]) upload(app, target.files[0]);
    target.value = "";
  } });
  const mark = (on) => document.body.classList.toggle("dropping", on);
  document.addEventListener("dragover", (event) => {
    event.preventDefault();
    mark(true);
  });
  document.addEventListener("dragleave", (event) => event.relatedTarget || mark(false));
  document.addEventListener("drop", (event) => {
    event.preventDefault();
    mark(false);
    const [dropped, ...others] = event.dataTransfer.files;
    if (dropped) takeDropped(app, dropped);
    if (others.length) announce(`Only ${dropped.name} is sent; drop one file at a time.`, "error");
  });
  return element("div", { class: "drop" }, icon("import"), element("span", {}, "Drop a film here, or "),
    element("label", { class: "pick plain", for: "file" }, "Choose a file"), file);
}

/** Open a film that was dropped; on the page of a film, all else are rows that belong to it. */
async function takeDropped(app, file) {
  const formats = await tried(ask("/api/formats"));
  if (!formats) return;
  if (formats.films.some((ending) => file.name.toLowerCase().endsWith(ending))) upload(app, file);
  else if (app.store.state.session) bring(app, file, "", "Not imported; Export and import (X) has a menu of formats: ");
  else announce(`${file.name} was not taken: it does not end like a film. Drop rows on the page of their film.`, "error");
}

/** Send a film to the server as it is, and open it. */
async function upload(app, film) {
  const [progress, end] = ongoing(`Sending ${film.name} …`);
  const sent = send(`/api/uploads?name=${encodeURIComponent(film.name)}`, film, progress);
  const kept = await tried(sent, `${film.name} was not taken: `);
  if (kept) await openFilm(app, kept.name, true);
  end();
}
