// Turns gestures and keys into calls that move the camera. One call is on its way at a time; what is
// asked for meanwhile is summed up, so that no step is lost.

const DEGREES_PER_PIXEL = 0.35;
const KEY_DEGREES = 5;
const KEY_PIXELS = 20;
const KEY_ZOOM = 1.1;

const sub = (a, b) => a.map((x, i) => x - b[i]);
const along = (a, b, t) => a.map((x, i) => x + b[i] * t);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const unit = (a) => a.map((x) => x / Math.hypot(...a));

export class Camera {
  #rpc;
  #canvas;
  #fail;
  #turn = { yaw: 0, pitch: 0, zoom: 1 };
  #shift = [0, 0]; // pixels by which the target moves
  #busy = false;

  // fail: called with the error of a call.
  constructor(rpc, canvas, fail) {
    this.#rpc = rpc;
    this.#canvas = canvas;
    this.#fail = fail;
  }

  orbit(right, down) {
    this.#turn.yaw -= right * DEGREES_PER_PIXEL;
    this.#turn.pitch += down * DEGREES_PER_PIXEL;
    this.#send();
  }

  zoom(factor) {
    this.#turn.zoom = Math.min(Math.max(this.#turn.zoom * factor, 0.001), 1000);
    this.#send();
  }

  // Moves the image with the pointer: the target goes the other way.
  shift(right, down) {
    this.#shift = [this.#shift[0] + right, this.#shift[1] + down];
    this.#send();
  }

  async #send() {
    if (this.#busy) return;
    this.#busy = true;
    try {
      for (;;) {
        const turn = this.#turn, shift = this.#shift;
        if (turn.yaw !== 0 || turn.pitch !== 0 || turn.zoom !== 1) {
          this.#turn = { yaw: 0, pitch: 0, zoom: 1 };
          await this.#rpc.call("camera.orbit", turn);
        } else if (shift[0] !== 0 || shift[1] !== 0) {
          this.#shift = [0, 0];
          await this.#moveTarget(shift);
        } else {
          return;
        }
      }
    } catch (error) {
      this.#fail(error);
    } finally {
      this.#busy = false;
    }
  }

  async #moveTarget([right, down]) {
    const { scene } = await this.#rpc.call("scene.get");
    const { position, target, up = [0, 1, 0], fov_y = 14 } = scene?.camera ?? {};
    if (!Array.isArray(position) || !Array.isArray(target))
      throw new Error("The target cannot be moved: the camera of this scene has no position.");
    const sight = sub(target, position);
    const across = unit(cross(sight, up)), upwards = unit(cross(across, sight));
    const perPixel =
      (2 * Math.hypot(...sight) * Math.tan((fov_y * Math.PI) / 360)) / this.#canvas.clientHeight;
    const moved = (point) =>
      along(along(point, across, -right * perPixel), upwards, down * perPixel);
    await this.#rpc.call("camera.set", { position: moved(position), target: moved(target) });
  }
}

// hover: called with 0 to 1 when a mouse without buttons is over the canvas.
export function listenToPointers(canvas, camera, hover) {
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
    const right = event.clientX - finger.x, down = event.clientY - finger.y;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (before > 0 && spread() > 0) camera.zoom(spread() / before);
    else if (event.shiftKey) camera.shift(right, down);
    else if (fingers.size === 1) camera.orbit(right, down);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 16 : 1);
      camera.zoom(Math.exp(-pixels / 600));
    },
    { passive: false },
  );
}

// step: called with -1 or 1 for the previous and the next view.
export function listenToKeys(canvas, camera, step) {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const way = ways[event.key];
    if (way && event.shiftKey) camera.shift(way[0] * KEY_PIXELS, way[1] * KEY_PIXELS);
    else if (way) camera.orbit(...way.map((x) => (x * KEY_DEGREES) / DEGREES_PER_PIXEL));
    else if (event.key === "+" || event.key === "=") camera.zoom(KEY_ZOOM);
    else if (event.key === "-") camera.zoom(1 / KEY_ZOOM);
    else if (event.key === "," || event.key === ".") step(event.key === "." ? 1 : -1);
    else return;
    event.preventDefault();
  });
}
