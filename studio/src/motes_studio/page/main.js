// The page: one state, one connection, and the views that draw it.

import { Actions } from "./actions.js";
import { announce } from "./announce.js";
import { button, calm, element, fillAnew, loadIcons } from "./dom.js";
import { Connection } from "./connection.js";
import { plural } from "./derived.js";
import { makeDialogs } from "./dialogs.js";
import { mountCountPanel } from "./count_panel.js";
import { mountDoubtPanel } from "./doubt_panel.js";
import { mountEditing } from "./editing.js";
import { mountHome, refreshHome } from "./home.js";
import { mountKeyboard } from "./keyboard.js";
import { mountLayerPanel } from "./layer_panel.js";
import { mountObjects } from "./objects.js";
import { mountStage } from "./stage.js";
import { mountStrip } from "./strip.js";
import { mountTabs } from "./tabs.js";
import { mountTimeline } from "./timeline.js";
import { mountTools, mountTransport } from "./toolbar.js";
import { Pictures } from "./pictures.js";
import { Player } from "./player.js";
import { Store } from "./store.js";
import { startTheme, switchTheme } from "./theme.js";
import { freshSession, initialState } from "./state.js";

const part = (name) => document.getElementById(name);

const store = new Store(initialState());
const pictures = new Pictures();
const player = new Player(store, pictures);

/** All parts of the page; tests read its state. */
export const app = { store, pictures, player, connection: null };
app.actions = new Actions(app);
app.dialogs = makeDialogs(app);
app.viewNow = () => (store.state.film ? app.stage.view() : null);

/** Zoom by a key: in, out, or to the whole film. */
app.zoom = (key) => {
  const { width, height } = app.stage.size();
  const factor = key === "-" ? 0.8 : 1.25;
  store.set({ view: key === "0" ? null : app.stage.view().zoomed(factor, [width / 2, height / 2]) });
};

startTheme(store);
mountHome(part("home"), app);
mountObjects(part("left"), app);
mountTools(part("tools"), app);
mountTransport(part("transport"), app);
mountStrip(part("strip"), app);
mountTimeline(part("timeline"), app);
mountTabs(part("right"), app, [
  ["layers", "Layers", mountLayerPanel(app)],
  ["doubts", "Doubts", mountDoubtPanel(app)],
  ["count", "Count", mountCountPanel(app)],
]);
mountKeyboard(app);
app.stage = mountStage(part("stage"), app);
mountEditing(app.stage, app);

new ResizeObserver(() => store.touch("sized")).observe(part("stage"));

/** While a run is followed, the film shows the newest frame; pictures that come late hold it up, and are not asked for. */
store.on(["newest", "picture"], ({ following, newest }) => {
  if (following && newest && player.free) player.show(newest.frame);
});

const bar = {
  undo: button("Undo (Ctrl+Z)", () => app.actions.undo(), { picture: "undo" }),
  redo: button("Redo (Ctrl+Y)", () => app.actions.redo(), { picture: "redo" }),
  exports: button("Export and import (X)", () => app.dialogs.exports(), { picture: "export", text: "Export", class: "plain" }),
  command: button("Command line (C)", () => app.dialogs.command(), { picture: "command" }),
  help: button("Keys (?)", () => app.dialogs.help(), { picture: "doubt" }),
  theme: button("Light or dark", () => announce(`Colors: ${switchTheme(store)}`), { picture: "theme" }),
};
part("actions").append(...Object.values(bar));
store.on(["session", "connected"], ({ session, connected }) => {
  for (const name of ["undo", "redo", "exports", "command", "help"]) bar[name].hidden = !session;
  bar.undo.disabled = !session?.undo;
  bar.redo.disabled = !session?.redo;
  fillAnew(part("title"), [session?.film, connected], () => (session ? titleOf(session.film, connected) : []));
  document.title = session ? `${session.film.name} – motes studio` : "motes studio";
});

function titleOf({ name, width, height, frames, problems }, connected) {
  const warning = (text) => element("span", { class: "warning", role: "status", title: text }, text);
  return [
    element("h1", { title: name }, name),
    element("span", { class: "muted" }, `${width} × ${height}, ${plural(frames, "frame")}`),
    problems ? warning(`Read with problems: ${problems}. The frames are those of motes track.`) : null,
    connected ? null : warning("The server does not answer; trying again …"),
  ];
}

/** The address names the session and the frame that is seen: #id/frame, or nothing for the first page. */
function route() {
  const [id, frame] = decodeURIComponent(location.hash.slice(1)).split("/");
  app.connection?.close();
  app.connection = null;
  pictures.clear();
  store.set({ ...freshSession(), frame: Math.max(0, parseInt(frame) || 0) });
  part("home").hidden = Boolean(id);
  part("session").hidden = !id;
  if (id) app.connection = new Connection(store, id);
  refreshHome(app);
}

/** What is loaded again, or sent to another person, begins at this frame. Browsers refuse many changes in a second. */
store.on(["frame", "session"], calm(() => {
  const { session, frame } = store.state;
  if (session && location.hash.startsWith(`#${session.id}`)) history.replaceState(null, "", `#${session.id}/${frame}`);
}, 500));

addEventListener("hashchange", route);
await loadIcons();
route();
