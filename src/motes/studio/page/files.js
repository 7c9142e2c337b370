// Files that go out and come in, and the command line that makes the same rows.

import { ask, reason, send } from "./api.js";
import { announce, read } from "./announce.js";
import { button, element, field } from "./dom.js";
import { show } from "./dialogs.js";
import { selectedItem } from "./derived.js";

/** Show what can be exported, and a place for rows that come in. */
export async function showExports(app) {
  const { session } = app.store.state;
  let formats = [];
  try {
    formats = await ask(`/api/formats`);
  } catch (error) {
    announce(error.message, "error");
    return;
  }
  const objects = session.objects.filter(({ tracked }) => tracked);
  const which = element("select", {}, element("option", { value: "" }, "All objects"),
    objects.map(({ object, name }) => element("option", { value: object }, name)));
  which.value = selectedItem(app.store.state)?.tracked ? String(app.store.state.selected) : "";
  const format = element("select", {}, formats.filter(({ write }) => write).map(({ name, title }) =>
    element("option", { value: name }, `${name} – ${title}`)));
  format.value = "rows.csv";
  if (!format.value) format.selectedIndex = 0;
  const base = `/api/sessions/${session.id}`;
  const query = () => (which.value ? `&object=${which.value}` : "");
  const take = (label, address) => button(label, () => download(address()), { class: "plain grow" });
  const file = element("input", { type: "file", onchange: ({ target }) => bring(app, target.files[0]) });
  show("Export and import", [
    element("section", { class: "stack" }, element("h3", {}, "Take home"),
      element("div", { class: "row even" }, field("Objects", which), field("Format", format)),
      element("div", { class: "row" },
        button("Export", () => download(`${base}/export?format=${encodeURIComponent(format.value)}${query()}`), { class: "main grow", picture: "export", text: "Export" }),
        take("Annotated film", () => `${base}/film?${query()}`),
        take("Figures", () => `${base}/figures?${query()}`))),
    element("section", { class: "stack" }, element("h3", {}, "Bring in"),
      element("p", { class: "muted" }, "Rows or annotations in a format that motes convert reads."), file),
  ]);
}

/** Fetch a file and hand it to the browser; a refusal is shown instead. */
async function download(address) {
  try {
    const answer = await fetch(address);
    if (!answer.ok) throw new Error(await reason(answer));
    const named = /filename\*?=(?:UTF-8'')?"?([^";]+)/.exec(answer.headers.get("content-disposition") ?? "");
    const link = element("a", { href: URL.createObjectURL(await answer.blob()), download: decodeURIComponent(named?.[1] ?? "tracks") });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60000);
  } catch (error) {
    announce(error.message, "error");
  }
}

async function bring({ store }, file) {
  if (!file) return;
  try {
    await send(`/api/sessions/${store.state.session.id}/import?name=${encodeURIComponent(file.name)}`, file, () => {});
    announce(`${file.name} was imported.`);
  } catch (error) {
    announce(`${file.name} was not imported: ${error.message}`, "error");
  }
}

/** Show the command line and the TOML file that make the same rows. */
export async function showCommand({ store }) {
  const { session, selected } = store.state;
  try {
    const address = `/api/sessions/${session.id}/command${selected === null ? "" : `?object=${selected}`}`;
    const { command, toml } = await ask(address);
    show("The same run on the command line", [
      block("Command", command),
      ...(toml ? [block("config.toml", toml)] : []),
    ]);
  } catch (error) {
    announce(error.message, "error");
  }
}

function block(title, text) {
  const copy = button(`Copy ${title}`, async () => {
    await navigator.clipboard.writeText(text);
    copy.lastChild.textContent = "Copied";
    read(`${title} was copied`);
  }, { picture: "copy", text: "Copy", class: "plain" });
  return element("section", { class: "code" }, element("header", {}, element("h3", {}, title), copy), element("pre", { tabindex: "0", "aria-label": title }, text));
}
