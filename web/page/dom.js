// Elements of the page.

export const at = (id) => document.getElementById(id);

/**
 * An element. Attributes that begin with "on" are listeners; booleans are properties; undefined is
 * left out. Children are elements or texts.
 */
export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name.slice(2), value);
    else if (typeof value === "boolean") element[name] = value;
    else if (value !== undefined) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

export function button(text, onclick, attributes = {}) {
  return make("button", { type: "button", onclick, ...attributes }, text);
}

/** Gives a select new options: [value, text] pairs. The first is chosen. */
export function fill(list, choices) {
  list.replaceChildren(
    ...choices.map(([value, text = value]) => make("option", { value: String(value) }, text)),
  );
  list.selectedIndex = choices.length ? 0 : -1;
}

export function select(choices, attributes = {}) {
  const list = make("select", attributes);
  fill(list, choices);
  return list;
}

/** A label in front of a field. */
export function labelled(text, field, ...more) {
  return make("label", { class: "line" }, make("span", {}, text), field, ...more);
}

/** Shows in `about` what the field means that has the focus or the pointer. */
export function explain(place, about) {
  const show = ({ target }) => {
    const row = target.closest("[data-about]");
    if (row?.dataset.about)
      about.textContent = `${row.querySelector("span").textContent}: ${row.dataset.about}`;
  };
  place.addEventListener("focusin", show);
  place.addEventListener("pointerover", show);
}

export function heading(text) {
  return make("h2", {}, text);
}
