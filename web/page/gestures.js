// Turns pointers and keys on the picture into moves.

import { DEGREES_PER_PIXEL } from "./camera.js";

const KEY_DEGREES = 5;
const KEY_PIXELS = 20;
const KEY_ZOOM = 1.1;

/**
 * @param hand returns what moves now: {turn, shift, zoom}, in pixels and factors
 * @param hover called with 0 to 1 when a mouse without buttons is over the canvas
 */
export function listenToPointers(canvas, hand, hover) {
  const fingers = new Map();
  const spread = () => {
    const [a, b] = fingers.values();
    return Math.hypot(a.x - b.x, a.y - b.y);
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  canvas.addEventListener("pointermove", (event) => {
    const finger = fingers.get(event.pointerId);
    if (!finger) {
      const box = canvas.getBoundingClientRect();
      return hover((event.clientX - box.left) / box.width);
    }
    const before = fingers.size === 2 ? spread() : 0;
    const right = event.clientX - finger.x,
      down = event.clientY - finger.y;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (before > 0 && spread() > 0) hand().zoom(spread() / before);
    else if (event.shiftKey) hand().shift(right, down);
    else if (fingers.size === 1) hand().turn(right, down);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
      hand().zoom(Math.exp(-pixels / 600));
    },
    { passive: false },
  );
}

/** @param step called with -1 or 1 for the previous and the next view */
export function listenToKeys(canvas, hand, step) {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = ways[event.key];
    if (way && event.shiftKey) hand().shift(way[0] * KEY_PIXELS, way[1] * KEY_PIXELS);
    else if (way) hand().turn(...way.map((x) => (x * KEY_DEGREES) / DEGREES_PER_PIXEL));
    else if (event.key === "+" || event.key === "=") hand().zoom(KEY_ZOOM);
    else if (event.key === "-") hand().zoom(1 / KEY_ZOOM);
    else if (event.key === "," || event.key === ".") step(event.key === "." ? 1 : -1);
    else return;
    event.preventDefault();
  });
}
