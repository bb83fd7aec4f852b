// The picture and the controls below it.

import { Camera } from "./camera.js";
import { at, fill } from "./dom.js";
import { listenToKeys, listenToPointers } from "./gestures.js";
import { MODES, STEREO, viewAt } from "./stereo.js";
import { recall, remember } from "./store.js";
import { QuiltView } from "./view.js";

const APART = [
  ["eyes", "6 degrees apart"],
  ["1", "1 view apart"],
  ["2", "2 views apart"],
  ["4", "4 views apart"],
  ["8", "8 views apart"],
];
const ZOOMS = [
  ["1", "1:1"],
  ["2", "2:1"],
  ["4", "4:1"],
  ["8", "8:1"],
];
const WHEEL_STEP = 1.3;

export class Stage {
  #rpc;
  #fail;
  #view;
  #camera;
  #calibration;
  #shown = { generation: 0 }; // the image: its generation, and the scene that it shows
  #next = {}; // aspect and cone of the newest generation
  #wheel = 1; // factors that are less than one step of the zoom
  canvas = at("preview");
  slider = at("view");

  constructor({ rpc, scene, fail }) {
    this.#rpc = rpc;
    this.#fail = fail;
    this.#view = new QuiltView(this.canvas);
    this.#camera = new Camera(rpc, this.canvas, () => scene.cameraMoves(), fail);
    this.#makeControls();
    listenToPointers(
      this.canvas,
      () => this.#hand(),
      (position) => this.turnTo(position),
    );
    listenToKeys(
      this.canvas,
      () => this.#hand(),
      (step) => this.turnTo(this.#view.position + step / Math.max(this.#view.views, 1)),
    );
    this.#followImages();
    rpc.addEventListener("device", () => this.#calibrate());
  }

  // What gestures move: the camera, or the part of the panel that is shown.
  #hand() {
    if (this.#view.mode !== "panel") return this.#camera;
    const pan = (right, down) => this.#view.pan(right, down);
    return { turn: pan, shift: pan, zoom: (factor) => this.#wheelZoom(factor) };
  }

  #wheelZoom(factor) {
    const list = at("zoom");
    this.#wheel *= factor;
    const by = this.#wheel > WHEEL_STEP ? 1 : this.#wheel < 1 / WHEEL_STEP ? -1 : 0;
    if (!by) return;
    this.#wheel = 1;
    list.selectedIndex = Math.min(Math.max(list.selectedIndex + by, 0), ZOOMS.length - 1);
    this.#apply();
  }

  #makeControls() {
    const offer = (id, choices, usual) => {
      const list = at(id);
      fill(list, choices);
      const kept = recall(id, usual);
      list.value = choices.some(([value]) => value === kept) ? kept : usual;
      list.addEventListener("change", () => this.#apply());
    };
    offer("mode", Object.entries(MODES), "view");
    offer("apart", APART, "eyes");
    offer("zoom", ZOOMS, "1");
    this.#view.position = recall("view", 0.5);
    this.slider.value = this.#view.position;
    this.slider.addEventListener("input", () => this.turnTo(Number(this.slider.value)));
    this.#apply();
  }

  #apply() {
    const mode = at("mode").value,
      apart = at("apart").value,
      zoom = at("zoom").value;
    remember("mode", mode);
    remember("apart", apart);
    remember("zoom", zoom);
    at("apart").hidden = !STEREO.includes(mode);
    at("zoom").hidden = mode !== "panel";
    at("view-line").hidden = mode === "quilt" || mode === "panel";
    this.canvas.dataset.mode = mode;
    if (mode === "panel" && !this.#calibration) this.#calibrate();
    this.#view.set({ mode, apart, zoom: Number(zoom) });
  }

  /** The connection is there: what was asked for before may have changed. */
  connected() {
    this.#shown.generation = 0; // a daemon that was started again counts from 1
    this.#rpc.call("preview.start").catch(this.#fail);
    this.#calibrate();
  }

  // Without a panel there is no simulation of one.
  async #calibrate() {
    const option = at("mode").querySelector('[value="panel"]');
    this.#calibration = await this.#rpc.call("device.calibration").catch(() => undefined);
    option.disabled = !this.#calibration;
    if (option.disabled && at("mode").value === "panel") {
      at("mode").value = "view";
      this.#apply();
    }
    this.#view.set({ calibration: this.#calibration });
  }

  turnTo(position) {
    this.#view.position = position;
    this.slider.value = this.#view.position;
    const { views } = this.#view,
      shown = Math.round(viewAt(this.#view.position, views));
    at("view-number").textContent = views ? `View ${shown + 1} of ${views}` : "View";
    remember("view", this.#view.position);
  }

  #followImages() {
    this.#rpc.addEventListener("image", async ({ detail }) => {
      try {
        const header = await this.#view.show(detail);
        this.canvas.dataset.generation = header.generation;
        this.#take(header);
        at("empty").hidden = true;
        this.slider.disabled = header.views < 2;
        this.turnTo(this.#view.position);
      } catch (error) {
        this.#fail(error);
      } finally {
        this.#rpc.notify("preview.ack");
      }
    });
  }

  // An image has come. If its tiles have another shape, they know theirs until a status does.
  #take({ generation, width, height }) {
    const tile = width / height;
    if (this.#shown.tile && Math.abs(tile / this.#shown.tile - 1) > 0.01)
      this.#view.set({ aspect: undefined });
    Object.assign(this.#shown, { generation, tile });
    this.#takeShape();
  }

  // The shape of a status is for its own image: that before it keeps its shape, and is dimmed.
  #takeShape() {
    const { generation, scene, aspect, cone, level } = this.#next;
    const old = this.#view.views > 0 && this.#shown.generation < (generation ?? 0);
    this.canvas.classList.toggle("old", old && level === "none");
    if (old || generation < this.#shown.generation) return;
    this.#shown.scene = scene;
    this.#view.set({ aspect, cone: cone ?? 40 });
  }

  /** Whether the picture is still that of another scene. */
  waits({ scene }) {
    return this.#shown.scene !== undefined && this.#shown.scene !== scene;
  }

  status(status) {
    this.#next = status;
    this.#takeShape();
  }
}

/** Lets files be dropped anywhere on the page. @param take called with a DataTransfer */
export function acceptFiles(take) {
  const sign = at("drop"),
    isFile = (event) => event.dataTransfer.types.includes("Files");
  addEventListener("dragover", (event) => {
    if (!isFile(event)) return;
    event.preventDefault();
    sign.hidden = false;
  });
  addEventListener("dragleave", (event) => (sign.hidden ||= !event.relatedTarget));
  addEventListener("drop", (event) => {
    sign.hidden = true;
    if (!isFile(event)) return;
    event.preventDefault();
    take(event.dataTransfer);
  });
}

/** On a phone the settings are a sheet of three heights; its handle is dragged or pressed. */
export function makeSheet(side, handle) {
  const sizes = ["low", "half", "tall"];
  const show = (size) => {
    side.dataset.size = size;
    handle.setAttribute("aria-expanded", String(size !== "low"));
    remember("sheet", size);
  };
  let from;
  handle.addEventListener("pointerdown", (event) => {
    from = event.clientY;
    handle.setPointerCapture(event.pointerId);
  });
  handle.addEventListener("pointerup", (event) => {
    const up = from - event.clientY,
      i = sizes.indexOf(side.dataset.size);
    if (Math.abs(up) > 20) show(sizes[Math.min(Math.max(i + Math.sign(up), 0), 2)]);
  });
  handle.addEventListener("click", (event) => {
    if (event.detail && Math.abs(from - event.clientY) > 20) return; // that was a drag
    show(sizes[(sizes.indexOf(side.dataset.size) + 1) % 3]);
  });
  show(recall("sheet", "half"));
  return () => side.dataset.size === "low" && show("half");
}
