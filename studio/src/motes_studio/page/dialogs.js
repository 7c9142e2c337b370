// The dialogs: help, absence, removal. Files have their own in files.js.

import { ask } from "./api.js";
import { tried } from "./announce.js";
import { button, element, field, form } from "./dom.js";
import { helpOf } from "./keyboard.js";
import { showCommand, showExports } from "./files.js";
import { refreshHome } from "./home.js";
import { numbersIn } from "./numbers.js";

let numbered = 0;

/**
 * Show a dialog: Escape or its cross close it, and the focus goes back to where it was. It begins at the first field, and
 * Enter in a field presses the main button.
 */
export function show(title, body, footer = []) {
  const id = `dialog-${(numbered += 1)}`;
  const fields = form(element("div", { class: "body" }, body), footer.length ? element("footer", {}, footer) : null);
  fields.querySelector("input, select, button")?.setAttribute("autofocus", "");
  const dialog = element("dialog", { "aria-labelledby": id },
    element("header", {}, element("h2", { id }, title), button("Close", () => dialog.close(), { picture: "close" })),
    fields);
  const said = document.getElementById("said"); // what is behind a dialog cannot be pressed, and is not read
  dialog.addEventListener("close", () => {
    dialog.remove();
    (document.querySelector("dialog[open]") ?? document.body).append(said);
  });
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  document.body.append(dialog);
  dialog.append(said);
  dialog.showModal();
  return dialog;
}

/** Return the dialogs by their names. */
export function makeDialogs(app) {
  const { store, actions } = app;
  return {
    help: () => show("Keys", element("div", { class: "keys" }, helpOf(app).map(([title, keys]) =>
      element("section", {}, element("h3", {}, title), element("dl", {}, keys.map(([names, what]) => [
        element("dt", {}, names.map((name) => element("kbd", {}, name))), element("dd", {}, what),
      ])))))),
    exports: () => showExports(app),
    command: () => showCommand(app),

    absent() {
      const { frame, film } = store.state;
      const input = (value) => element("input", { type: "number", min: "0", max: film.frames - 1, step: "1", value });
      const [first, last] = [input(frame), input(frame)];
      const dialog = show("Absent from … to …", [
        element("p", { class: "muted" }, "The object is not in these frames; both ends are included."),
        element("div", { class: "row even" }, field("First frame", first), field("Last frame", last)),
      ], [button("Mark as absent", () => {
        const ends = numbersIn([first, last]);
        if (!ends) return;
        dialog.close();
        actions.absentBetween(...ends);
      }, { class: "main" })]);
    },

    remove(id, film) {
      const dialog = show("Delete the session?", element("p", {}, `The tracks and corrections of ${film} in this session are deleted. The film stays.`),
        [button("Keep it", () => dialog.close(), { class: "plain" }), button("Delete", async () => {
          dialog.close();
          await tried(ask(`/api/sessions/${id}`, { method: "DELETE" }));
          refreshHome(app);
        }, { class: "plain bad" })]);
    },
  };
}
