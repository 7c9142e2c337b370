// The panel on the right: one tab each for layers, doubtful frames and counting.

import { element } from "./dom.js";

/** Show one of several panels: [name, title, node] each. Arrows go from tab to tab. */
export function mountTabs(root, { store }, panels) {
  const list = element("div", { role: "tablist", class: "tabs", "aria-label": "Details" });
  const tabs = panels.map(([name, title, panel]) => {
    const tab = element("button", {
      type: "button", role: "tab", id: `tab-${name}`, "aria-controls": `panel-${name}`,
      onclick: () => store.set({ tab: name }),
    }, title);
    panel.id = `panel-${name}`;
    panel.setAttribute("role", "tabpanel");
    panel.setAttribute("aria-labelledby", tab.id);
    panel.tabIndex = 0;
    return [name, tab, panel];
  });
  list.addEventListener("keydown", ({ key }) => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[key];
    if (!step) return;
    const at = tabs.findIndex(([name]) => name === store.state.tab);
    const [name, tab] = tabs[(at + step + tabs.length) % tabs.length];
    store.set({ tab: name });
    tab.focus();
  });
  list.append(...tabs.map(([, tab]) => tab));
  root.append(list, ...tabs.map(([, , panel]) => panel));
  store.on(["tab"], ({ tab: chosen }) => {
    for (const [name, tab, panel] of tabs) {
      tab.setAttribute("aria-selected", String(name === chosen));
      tab.tabIndex = name === chosen ? 0 : -1;
      panel.hidden = name !== chosen;
    }
  });
}
