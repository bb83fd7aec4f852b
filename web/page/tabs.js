// Tabs by the ARIA pattern: one is in the order of the Tab key, arrow keys move among them.

import { make } from "./dom.js";
import { recall, remember } from "./store.js";

/**
 * @param list element with the role tablist
 * @param tabs [{id, name, panel}]: panel is the element of the tab; their parent scrolls
 * @param shown called with the id of a tab when it is shown
 */
export function makeTabs(list, tabs, shown) {
  const buttons = tabs.map(({ id, name, panel }) => {
    panel.id = `panel-${id}`;
    panel.setAttribute("role", "tabpanel");
    panel.setAttribute("aria-labelledby", `tab-${id}`);
    panel.tabIndex = 0;
    const attributes = { type: "button", id: `tab-${id}`, role: "tab", "aria-controls": panel.id };
    return make("button", { ...attributes, onclick: () => show(id) }, name);
  });
  const places = new Map(); // how far each tab is scrolled
  let now;
  function show(id) {
    const scroller = tabs[0].panel.parentElement;
    if (now !== undefined) places.set(now, scroller.scrollTop);
    now = id;
    tabs.forEach((tab, i) => {
      const chosen = tab.id === id;
      tab.panel.hidden = !chosen;
      buttons[i].setAttribute("aria-selected", String(chosen));
      buttons[i].tabIndex = chosen ? 0 : -1;
      if (chosen) buttons[i].scrollIntoView({ block: "nearest", inline: "nearest" });
    });
    scroller.scrollTop = places.get(id) ?? 0;
    remember("tab", id);
    shown(id);
  }
  list.addEventListener("keydown", (event) => {
    const there = buttons.filter((one) => !one.hidden);
    const i = there.indexOf(document.activeElement);
    const to = { ArrowRight: i + 1, ArrowLeft: i - 1, Home: 0, End: -1 }[event.key];
    if (i < 0 || to === undefined) return;
    const next = there[(to + there.length) % there.length];
    next.focus();
    next.click();
    event.preventDefault();
  });
  list.append(...buttons);
  const kept = recall("tab");
  show(tabs.some(({ id }) => id === kept) ? kept : tabs[0].id);
  return show;
}
