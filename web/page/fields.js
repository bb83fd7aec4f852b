// Fields for the values of a scene. Each function returns {element, set}; `commit` is called with a
// new value and the group of the gesture that made it.

import { hexOf, linearOf, splitColour, withStrength } from "./colour.js";
import { make, select } from "./dom.js";
import { tidy } from "./numbers.js";
import { freshGroup, scrub } from "./scrub.js";

function vector({ label, range, commit }, count) {
  let values = [];
  const names = ["x", "y", "z", "w"];
  const parts = Array.from({ length: count }, (_, i) =>
    scrub({
      label: `${label} ${names[i]}`,
      range,
      commit: (value, group) => {
        values = values.map((old, k) => (k === i ? value : old));
        commit(values, group);
      },
    }),
  );
  return {
    element: make(
      "div",
      { class: "vector", role: "group", "aria-label": label },
      ...parts.map((p) => p.element),
    ),
    set(next) {
      values = next;
      parts.forEach((part, i) => part.set(next[i]));
    },
  };
}

const precise = (colour) => colour.map((x) => tidy(x, 4));

// A colour within 0 to 1, such as an albedo: the field shows it as it is.
function unitColour({ label, commit }) {
  let group;
  const picker = make("input", { type: "color", "aria-label": label });
  picker.addEventListener("input", () =>
    commit(precise(linearOf(picker.value)), (group ??= freshGroup())),
  );
  picker.addEventListener("change", () => (group = undefined));
  return {
    element: picker,
    set(value) {
      picker.value = hexOf(Array.isArray(value) ? value : [value, value, value]);
    },
  };
}

// Light may be brighter than 1: a colour times a strength.
function lightColour({ label, range, commit }) {
  let value = 0,
    group;
  const picker = make("input", { type: "color", "aria-label": label });
  const strength = scrub({
    label: `${label}, strength`,
    range,
    commit: (next, of) => commit(change(next), of),
  });
  const change = (next) => {
    const scaled = withStrength(value, next);
    return Array.isArray(scaled) ? precise(scaled) : scaled;
  };
  picker.addEventListener("input", () => {
    const by = splitColour(value).strength || 1;
    commit(precise(linearOf(picker.value).map((x) => x * by)), (group ??= freshGroup()));
  });
  picker.addEventListener("change", () => (group = undefined));
  return {
    element: make(
      "div",
      { class: "colour", role: "group", "aria-label": label },
      picker,
      strength.element,
    ),
    set(next) {
      // black has no hue: the field keeps the one before
      const split = splitColour(next);
      if (split.strength > 0 || value === 0) value = next;
      if (!group) picker.value = splitColour(value).hex;
      strength.set(split.strength);
    },
  };
}

function choice({ label, words, commit }) {
  const list = select(
    words.map((word) => [word]),
    { "aria-label": label },
  );
  list.addEventListener("change", () => commit(words[list.selectedIndex], freshGroup()));
  return { element: list, set: (value) => (list.selectedIndex = words.indexOf(value)) };
}

function toggle({ label, commit }) {
  const box = make("input", { type: "checkbox", "aria-label": label });
  box.addEventListener("change", () => commit(box.checked, freshGroup()));
  return { element: make("label", { class: "check" }, box), set: (value) => (box.checked = value) };
}

// A text, or any other value as JSON.
function text({ label, list, commit }, read, write) {
  const input = make("input", {
    type: "text",
    class: "text",
    list,
    "aria-label": label,
    autocomplete: "off",
    spellcheck: "false",
  });
  let shown = "";
  const take = () => {
    if (input.value === shown) return;
    try {
      commit(read(input.value), freshGroup());
      input.removeAttribute("aria-invalid");
    } catch {
      input.setAttribute("aria-invalid", "true");
    }
  };
  input.addEventListener("change", take);
  return {
    element: input,
    set(value) {
      const editing = document.activeElement === input && input.value !== shown;
      shown = write(value);
      if (!editing) input.value = shown;
    },
  };
}

/**
 * A field.
 * @param kind see fieldOf of schema.js
 * @param options {label, range, words, bounded, list, commit}; words of a choice; bounded: a colour
 * within 0 to 1; list: id of a datalist for texts
 */
export function makeField(kind, options, value) {
  if (kind === "number") return scrub(options);
  if (kind === "vector") return vector(options, value.length);
  if (kind === "colour") return options.bounded ? unitColour(options) : lightColour(options);
  if (kind === "choice") return choice(options);
  if (kind === "switch") return toggle(options);
  if (kind === "text")
    return text(
      options,
      (word) => word,
      (word) => word,
    );
  return text(options, JSON.parse, (word) => JSON.stringify(word));
}
