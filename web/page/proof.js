// The proof of a print: images of an eye that moves across the sheet, in one column.

import { make } from "./dom.js";

/** Images of a proof, and their range: this many times the range of the views (daemon/output). */
export const EYES = 25;
export const BEYOND = 1.3;

/** How far the column must be raised to show the image of an eye, in percent of it; eye 0 is at its bottom. */
export function raiseOf(eye) {
  return (100 * (EYES - 1 - eye)) / EYES;
}

/** Where an eye is, as a share of the range of the views: 0 in the middle, ±0.5 where they jump. */
export function shareOf(eye) {
  return BEYOND * (eye / (EYES - 1) - 0.5);
}

/** What is said of it. */
export function wordsOf(eye) {
  const share = shareOf(eye);
  if (Math.abs(share) > 0.5) return "beyond the jump";
  return Math.abs(share) < 0.01 ? "in the middle" : `${Math.round(200 * Math.abs(share))} % of the way to the jump`;
}

/** An element with the proof under this address, and a slider for the eye. */
export function proofView(path) {
  const column = make("img", { src: path, alt: "The print through its sheet" });
  const seen = make("div", { class: "seen" }, column);
  const eye = make("input", {
    type: "range",
    min: "0",
    max: String(EYES - 1),
    step: "1",
    value: String((EYES - 1) / 2),
    "aria-label": "Position of the eye",
  });
  const text = make("output", { class: "number" });
  const show = () => {
    column.style.translate = `0 ${-raiseOf(Number(eye.value))}%`;
    text.textContent = wordsOf(Number(eye.value));
  };
  column.addEventListener("load", () => {
    seen.style.aspectRatio = `${column.naturalWidth} / ${column.naturalHeight / EYES}`;
    show();
  });
  eye.addEventListener("input", show);
  return make("div", { class: "proof" }, seen, eye, text);
}
