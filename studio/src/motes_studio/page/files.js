// Files that go out and come in, and the command line that makes the same rows.

import { answerOf, ask, send } from "./api.js";
import { announce, read, tried } from "./announce.js";
import { button, element, field } from "./dom.js";
import { show } from "./dialogs.js";

const SAID = 5; // kinds of things left out that are named; the others are counted

/** Show what can be exported, and a place for rows that come in. */
export async function showExports(app) {
  const { session, scene } = app.store.state;
  const formats = await tried(ask("/api/formats"));
  if (!formats) return;
  const base = `/api/sessions/${session.id}`;
  const tracked = session.objects.filter((item) => item.tracked);
  const which = element("select", {}, element("option", { value: "" }, "All objects"),
    tracked.map(({ object, name }) => element("option", { value: object }, name)));
  const left = session.objects.filter((item) => !item.tracked).map(({ name }) => name);
  const format = element("select", {}, formatOptions({ ...formats.write, corrections: "for motes refine, beside the rows" }));
  const rows = element("select", {}, formatOptions(formats.write));
  const object = () => (which.value ? `object=${which.value}` : "");
  const guesses = element("input", { type: "checkbox" });
  const chosen = ({ value }) => `format=${encodeURIComponent(value)}&guesses=${guesses.checked}`;
  const asSeen = element("label", { class: "check" }, guesses, "Labels with guesses, as if they were seen");
  const take = (label, address, properties) =>
    button(label, ({ currentTarget }) => download(currentTarget, address()), { class: "plain grow", text: label, ...properties });
  const read = element("select", {}, element("option", { value: "" }, "recognized by the content"), formatOptions(formats.read));
  const file = element("input", { type: "file", "aria-label": "File to import", onchange: ({ target }) => {
    bring(app, target.files[0], read.value);
    target.value = ""; // the same file may be chosen again, with a format
  } });
  show("Export and import", [
    tracked.length ? element("section", { class: "stack" }, element("h3", {}, "Take home"),
      element("div", { class: "row even" }, field("Objects", which), field("Format", format)),
      left.length ? element("p", { class: "muted" }, `Without those that are not tracked to their end: ${left.join(", ")}.`) : null,
      element("div", { class: "row" },
        take("Export", () => `${base}/export?${chosen(format)}&${object()}`, { class: "main grow", picture: "export" }),
        take("Annotated film", () => `${base}/film?${object()}`)))
      : element("p", { class: "muted" }, "Track an object, and its rows can be taken home here."),
    scene.length ? element("section", { class: "stack" }, element("h3", {}, "All that moves"),
      field("Format of the rows", rows),
      element("div", { class: "row" },
        take("Rows of all objects", () => `${base}/export?scene&${chosen(rows)}`),
        take("Events", () => `${base}/export?scene&format=events`))) : null,
    tracked.length || scene.length ? asSeen : null,
    element("section", { class: "stack" }, element("h3", {}, "Bring in"),
      element("p", { class: "muted" }, "Rows or annotations in a format that motes convert reads; a folder as ZIP."),
      field("Format of the file", read), file),
  ]);
}

const formatOptions = (formats) =>
  Object.entries(formats).map(([name, title]) => element("option", { value: name }, `${name} – ${title}`));

/** Fetch a file and hand it to the browser; a refusal is shown instead. */
async function download(pressed, address) {
  pressed.disabled = true;
  const answer = await tried(answerOf(address));
  const content = answer && (await tried(answer.blob()));
  pressed.disabled = false;
  if (!content) return;
  const [, name] = answer.headers.get("content-disposition").split("''");
  const link = element("a", { href: URL.createObjectURL(content), download: decodeURIComponent(name) });
  link.click();
  const said = answer.headers.get("motes-said");
  if (said) announce(`${link.download}: ${said}.`, "note");
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

/** Bring the rows of a file into the session; its format is recognized unless given. */
export async function bring({ store }, file, format, words = "Not imported: ") {
  if (!file) return;
  const query = new URLSearchParams({ name: file.name, format });
  const address = `/api/sessions/${store.state.session.id}/import?${query}`;
  const found = await tried(send(address, file), words);
  if (!found) return;
  const rest = found.left_out;
  const named = rest.slice(0, SAID).join("; ") + (rest.length > SAID ? `, and ${rest.length - SAID} more` : "");
  announce(`${file.name} was imported${rest.length ? `, without ${named}` : ""}.`, rest.length ? "error" : "note");
}

/** Show the command line and the files that make the same rows. */
export async function showCommand({ store }) {
  const { session, selected, scene } = store.state;
  const base = `/api/sessions/${session.id}/command`;
  const addresses = selected === null ? [] : [`${base}?object=${selected}`];
  if (scene.length || selected === null) addresses.push(base); // that of all that moves
  const runs = await Promise.all(addresses.map((address) => tried(ask(address))));
  if (runs.includes(null)) return;
  show("The same run on the command line", runs.flatMap(({ command, files, note }) =>
    [note ? element("p", {}, note) : null, block("Command", command), ...Object.entries(files).map(([name, text]) => block(name, text))]));
}

function block(title, text) {
  const copy = button(`Copy ${title}`, async () => {
    await navigator.clipboard.writeText(text);
    copy.lastChild.textContent = "Copied";
    read(`${title} was copied`);
  }, { picture: "copy", text: "Copy", class: "plain" });
  return element("section", { class: "code" }, element("header", {}, element("h3", {}, title), copy), element("pre", { tabindex: "0", "aria-label": title }, text));
}
