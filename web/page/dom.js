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

/** A select of [value, text] pairs. */
export function select(choices, attributes = {}) {
  const options = choices.map(([value, text = value]) => make("option", { value: String(value) }, text));
  return make("select", attributes, ...options);
}

/** A label in front of a field. */
export function labelled(text, field, ...more) {
  return make("label", { class: "line" }, make("span", {}, text), field, ...more);
}

export function heading(text) {
  return make("h2", {}, text);
}

let ids = 0;
export const freshId = (word) => `${word}-${++ids}`;
