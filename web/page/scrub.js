// A number that is dragged, typed, or changed by arrow keys.

import { make } from "./dom.js";
import { dragged, format, limit, nudged, parse } from "./numbers.js";

const SLACK_PX = 3;
let groups = 0;
/** A name for the changes of one gesture, which are one step of undo. */
export const freshGroup = () => `gesture-${Date.now()}-${++groups}`;

/**
 * @param label words for assistive technology
 * @param range see numbers.js
 * @param commit called with a value and the group of the gesture
 * @returns {element, set}; undefined stands for no value
 */
export function scrub({ label, range, commit }) {
  let value = 0,
    drag,
    keys,
    typing = false;
  const input = make("input", {
    type: "text",
    inputmode: "decimal",
    role: "spinbutton",
    class: "scrub",
    autocomplete: "off",
    "aria-label": label,
    "aria-valuemin": range.minimum,
    "aria-valuemax": range.maximum,
  });
  const show = () => {
    if (typing) return;
    input.value = value === undefined ? "" : format(value);
    if (value === undefined) input.removeAttribute("aria-valuenow");
    else input.setAttribute("aria-valuenow", String(value));
  };
  const change = (next, group) => {
    if (next === value) return;
    value = next;
    commit(value, group);
  };
  const take = () => {
    const typed = typing ? parse(input.value) : undefined;
    typing = false;
    if (typed !== undefined) change(limit(typed, range), freshGroup());
    show();
  };
  input.addEventListener("mousedown", (event) => {
    if (document.activeElement !== input) event.preventDefault(); // a drag does not select text
  });
  input.addEventListener("pointerdown", (event) => {
    if (event.button !== 0 || typing) return;
    drag = { x: event.clientX, from: value ?? range.minimum, moved: false, group: freshGroup() };
    input.setPointerCapture(event.pointerId);
  });
  input.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const pixels = event.clientX - drag.x;
    drag.moved ||= Math.abs(pixels) > SLACK_PX;
    if (!drag.moved) return;
    input.classList.add("dragged");
    change(dragged(drag.from, pixels * (event.shiftKey ? 0.1 : 1), range), drag.group);
    show();
  });
  const end = () => {
    if (drag && !drag.moved) {
      input.focus();
      input.select();
    }
    drag = undefined;
    input.classList.remove("dragged");
  };
  input.addEventListener("pointerup", end);
  for (const type of ["pointercancel", "lostpointercapture"])
    input.addEventListener(type, () => {
      drag = undefined;
      input.classList.remove("dragged");
    });
  input.addEventListener("input", () => (typing = true));
  input.addEventListener("change", take);
  input.addEventListener("blur", take);
  input.addEventListener("keyup", () => (keys = undefined));
  input.addEventListener("keydown", (event) => {
    const way = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    if (event.key === "Enter") return take();
    if (event.key === "Escape") {
      typing = false;
      return show();
    }
    if (!way) return;
    take();
    keys ??= freshGroup();
    change(nudged(value ?? range.minimum, way * (event.shiftKey ? 10 : 1), range), keys);
    show();
    event.preventDefault();
  });
  return {
    element: input,
    set(next) {
      if (drag?.moved) return;
      value = next;
      show();
    },
  };
}
