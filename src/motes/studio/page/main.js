// The page: one state, one connection, and the views that draw it.

import { Actions } from "./actions.js";
import { announce } from "./announce.js";
import { button, element, fillAnew, loadIcons } from "./dom.js";
import { Connection } from "./connection.js";
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
export const app = { store, pictures, player, connection: null, stages: [] };
app.actions = new Actions(app);
app.dialogs = makeDialogs(app);
app.viewNow = () => (app.stages[0] && store.state.film ? app.stages[0].view() : null);

/** Zoom by a key: in, out, or to the whole film. */
app.zoom = (key) => {
  const [stage] = app.stages;
  const { width, height } = stage.size();
  const factor = key === "-" ? 0.8 : 1.25;
  store.set({ view: key === "0" ? null : stage.view().zoomed(factor, [width / 2, height / 2]) });
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

/** One stage, or two side by side. */
store.on(["beside"], ({ beside }) => {
  app.stages.forEach((stage) => stage.remove());
  const sides = beside === null ? [0] : [0, 1];
  app.stages = sides.map((side) => {
    const stage = mountStage(part("stages"), app, side);
    mountEditing(stage, app, side);
    return stage;
  });
  store.set({ view: null });
});
new ResizeObserver(() => store.touch("sized")).observe(part("stages"));

store.on(["session"], ({ session, beside }) => {
  if (beside !== null && !session?.objects.some(({ object }) => object === beside)) store.set({ beside: null });
});

/** While a run is followed, the film shows the newest frame; pictures that come late hold it up, and are not asked for. */
store.on(["newest", "picture"], ({ following, newest }) => {
  if (following && newest && player.free) player.show(newest.frame);
});

const bar = {
  undo: button("Undo (Ctrl+Z)", () => app.actions.undo(), { picture: "undo" }),
  redo: button("Redo (Ctrl+Y)", () => app.actions.redo(), { picture: "redo" }),
  single: button("End side by side", () => store.set({ beside: null }), { picture: "compare", text: "Single view", class: "plain" }),
  exports: button("Export and import (X)", () => app.dialogs.exports(), { picture: "export", text: "Export", class: "plain" }),
  command: button("Command line (C)", () => app.dialogs.command(), { picture: "command" }),
  help: button("Keys (?)", () => app.dialogs.help(), { picture: "doubt" }),
  theme: button("Light or dark", () => announce(`Colors: ${switchTheme(store)}`), { picture: "theme" }),
};
part("actions").append(...Object.values(bar));
store.on(["session", "beside", "connected"], ({ session, beside, connected }) => {
  for (const name of ["undo", "redo", "exports", "command", "help"]) bar[name].hidden = !session;
  bar.single.hidden = beside === null;
  bar.undo.disabled = !session?.undo;
  bar.redo.disabled = !session?.redo;
  fillAnew(part("title"), [session?.film, connected], () => (session ? titleOf(session.film, connected) : []));
  document.title = session ? `${session.film.name} – motes studio` : "motes studio";
});

function titleOf({ name, width, height, frames, problems }, connected) {
  const warning = (text, title) => element("span", { class: "warning", role: "status", title }, text);
  return [
    element("h1", {}, name),
    element("span", { class: "muted" }, `${width} × ${height}, ${frames} frames`),
    problems ? warning(`Read with problems: ${problems}`, "The frames are those of motes track.") : null,
    connected ? null : warning("The server does not answer; trying again …"),
  ];
}

/** The address names the session: #id, or nothing for the first page. */
function route() {
  const id = decodeURIComponent(location.hash.slice(1));
  app.connection?.close();
  app.connection = null;
  pictures.clear();
  store.set(freshSession());
  part("home").hidden = Boolean(id);
  part("session").hidden = !id;
  if (id) app.connection = new Connection(store, id);
  refreshHome(app);
}

addEventListener("hashchange", route);
await loadIcons();
route();
