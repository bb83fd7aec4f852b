// The tab Picture: how good the image is, how it is rendered, and its depth.

import { fill, heading, labelled, make, select } from "./dom.js";
import { format } from "./numbers.js";
import { distanceOf, placed, targetAt } from "./rig.js";
import { freshGroup } from "./scrub.js";
import { depthText, errorText, progressOf } from "./words.js";

const REST_MS = 600;
const KEYS = [
  ["Move the mouse", "look from another view"],
  ["Drag, one finger, arrow keys", "turn the scene"],
  ["Wheel, two fingers, + and −", "come nearer or go away"],
  ["Shift with drag or arrow keys", "move the target"],
  [", and .", "previous and next view"],
  ["Ctrl+Z, Ctrl+Shift+Z", "undo and redo"],
];

function meter(name) {
  const bar = make("progress", {
    max: "1",
    value: "0",
    "aria-label": `${name}: share of the way to the target`,
  });
  const text = make("span", { class: "number" });
  return {
    element: make("div", { class: "meter" }, make("span", {}, name), bar, text),
    set(error, target) {
      bar.value = progressOf(error, target);
      text.textContent = errorText(error);
    },
  };
}

/**
 * A slider with its value in words. While it is held, `set` does not move it.
 * @param change called with the value and the group of the gesture
 */
function slider(name, attributes, change, words = (value) => format(value)) {
  let group, rest;
  const input = make("input", { type: "range", ...attributes });
  const text = make("output", { class: "number" });
  const show = () => (text.textContent = words(Number(input.value)));
  input.addEventListener("input", () => {
    show();
    clearTimeout(rest);
    change(Number(input.value), (group ??= freshGroup()));
  });
  // several presses of an arrow key are one gesture
  input.addEventListener("change", () => (rest = setTimeout(() => (group = undefined), REST_MS)));
  return {
    element: labelled(name, input, text),
    input,
    set(value) {
      if (group || value === undefined) return;
      input.value = value;
      show();
    },
  };
}

export class Picture {
  #scene;
  #status = {};
  #render;
  element = make("div");

  constructor({ scene, render }) {
    this.#scene = scene;
    this.#render = render;
    this.#make();
    scene.addEventListener("change", () => this.#showScene());
  }

  // Which values there are; hides what an older quiltd lacks.
  hello({ methods }) {
    const { properties = {} } = methods["render.set"]?.params ?? {};
    this.#choices(this.estimator, properties.estimator?.enum);
    this.#choices(this.integrator, properties.integrator?.enum);
    this.depth.element.hidden = !methods["camera.set"]?.params.properties.depthiness;
    this.guides.parentElement.hidden = !properties.guides;
  }

  #choices(list, words = []) {
    fill(
      list,
      words.map((word) => [word]),
    );
    list.parentElement.hidden = words.length === 0;
  }

  #make() {
    this.unfiltered = meter("Unfiltered");
    this.denoised = meter("Denoised");
    this.left = make("p", { id: "left" });
    this.target = select(
      ["1e-2", "3e-3", "1e-3", "3e-4", "1e-4", "3e-5", "1e-5"].map((e) => [Number(e), e]),
      { id: "target" },
    );
    this.target.addEventListener("change", () =>
      this.#render.set({ target_error: Number(this.target.value) }),
    );
    this.#makeLight();
    this.#makeDepth();
    const keys = make(
      "dl",
      {},
      ...KEYS.flatMap(([what, does]) => [make("dt", {}, what), make("dd", {}, does)]),
    );
    this.element.append(
      this.look,
      this.light,
      this.depths,
      make(
        "section",
        {},
        heading("Quality"),
        this.unfiltered.element,
        this.denoised.element,
        this.left,
        labelled("Error to reach", this.target),
        labelled("Denoise", this.denoise),
        labelled("Estimator", this.estimator),
        labelled("Integrator", this.integrator),
      ),
      make("details", { id: "keys" }, make("summary", {}, "Mouse, touch and keys"), keys),
    );
  }

  #makeLight() {
    this.auto = make("input", { type: "checkbox", id: "exposure-auto" });
    this.auto.addEventListener("change", () =>
      this.#render.set({ exposure: this.auto.checked ? "auto" : Number(this.exposure.input.value) }),
    );
    const range = { id: "exposure", min: "-8", max: "8", step: "0.125" };
    this.exposure = slider(
      "Exposure",
      range,
      (stops, group) => {
        this.auto.checked = false;
        this.#render.set({ exposure: stops }, group);
      },
      (stops) => `${stops > 0 ? "+" : ""}${format(stops)}`,
    );
    this.tone = select(
      [
        ["srgb", "None"],
        ["filmic", "Filmic"],
        ["aces", "ACES"],
        ["neutral", "Neutral"],
      ],
      { id: "tone" },
    );
    this.tone.addEventListener("change", () =>
      this.#scene.change({ film: { tonemap: this.tone.value } }, freshGroup()),
    );
    this.denoise = select(
      [
        ["on", "On"],
        ["off", "Off"],
      ],
      { id: "denoise" },
    );
    this.denoise.addEventListener("change", () => this.#render.set({ denoise: this.denoise.value }));
    this.estimator = select([], { id: "estimator" });
    this.estimator.addEventListener("change", () =>
      this.#render.set({ estimator: this.estimator.value }),
    );
    this.integrator = select([], { id: "integrator" });
    this.integrator.addEventListener("change", () =>
      this.#render.set({ integrator: this.integrator.value }),
    );
    this.light = make("section", {}, heading("Light"), labelled("Tone", this.tone));
  }

  #makeDepth() {
    this.budget = make("p", { id: "budget", class: "finding" });
    this.guides = make("input", { type: "checkbox", id: "guides" });
    this.guides.addEventListener("change", () => this.#render.set({ guides: this.guides.checked }));
    this.focus = slider(
      "Focus",
      { id: "focus", min: "-1", max: "1", step: "any" },
      (log, group) => this.#setFocus(Math.exp(log), group),
      (log) => format(Number(Math.exp(log).toPrecision(3))),
    );
    this.depth = slider(
      "Depth",
      { id: "depth", min: "0", max: "2", step: "0.01" },
      (depthiness, group) => this.#scene.change({ camera: { depthiness } }, group),
    );
    this.blur = slider(
      "View blur",
      { id: "blur", min: "0", max: "4", step: "0.05" },
      (view_blur, group) => this.#scene.change({ camera: { view_blur } }, group),
    );
    this.look = make(
      "section",
      {},
      this.exposure.element,
      labelled("Automatic", this.auto),
      this.focus.element,
      this.depth.element,
    );
    this.depths = make(
      "section",
      {},
      heading("Sharpness"),
      this.budget,
      this.blur.element,
      labelled(
        "Mark what is not sharp",
        this.guides,
        make("span", { class: "hint" }, "the panel shows the marks, too"),
      ),
    );
  }

  #setFocus(distance, group) {
    const camera = placed(this.#scene.document?.camera);
    if (camera) this.#scene.change({ camera: { target: targetAt(camera, distance) } }, group);
  }

  // An object without a scene, such as a quilt, has neither light nor depth to set.
  #showScene() {
    const { document } = this.#scene,
      camera = placed(document?.camera);
    for (const section of [this.look, this.light, this.depths]) section.hidden = !document;
    if (!document) return;
    this.focus.input.disabled = !camera;
    if (camera) this.#showFocus(camera);
    this.depth.set(document.camera?.depthiness ?? 1);
    this.blur.set(
      typeof document.camera?.view_blur === "object"
        ? undefined
        : (document.camera?.view_blur ?? 0),
    );
    this.blur.input.disabled = document.camera?.lens_radius > 0;
    this.tone.value = document.film?.tonemap ?? "srgb";
  }

  #showFocus(camera) {
    const { depth_budget: budget } = this.#status,
      now = distanceOf(camera);
    const near = Math.min(budget?.nearest > 0 ? budget.nearest : now / 2, now);
    const far = Math.max(budget?.farthest > 0 ? budget.farthest : now * 2, now);
    if (this.focus.input !== document.activeElement || !this.focus.input.min) {
      this.focus.input.min = Math.log(near * 0.95);
      this.focus.input.max = Math.log(far * 1.05);
    }
    this.focus.set(Math.log(now));
  }

  /** @param settings see Render.follow; left: words on the time left */
  status(status, settings, left) {
    this.#status = status;
    this.unfiltered.set(status.error_estimate, status.target_error);
    this.denoised.set(status.denoised_error, status.target_error);
    this.left.textContent = left;
    this.#showSettings(settings);
    const { text, level } = depthText(status.depth_budget);
    this.budget.textContent = text;
    this.budget.dataset.level = level;
    this.#showScene();
  }

  // Automatic exposure: the slider shows what was measured.
  #showSettings(settings) {
    this.#showTarget(settings.target_error);
    this.guides.checked = Boolean(settings.guides);
    for (const key of ["estimator", "integrator", "denoise"])
      if (settings[key]) this[key].value = settings[key];
    const { exposure } = settings;
    if (exposure === undefined) return;
    this.auto.checked = exposure === "auto";
    this.exposure.set(exposure === "auto" ? this.#status.exposure?.stops : exposure);
  }

  // A target that is none of the list is added to it.
  #showTarget(target) {
    if (!target) return;
    const values = [...this.target.options].map((option) => Number(option.value));
    if (!values.includes(target))
      this.target.append(make("option", { value: String(target) }, target.toExponential(0)));
    this.target.value = String(target);
  }
}
