// The scene that the daemon shows, as this page knows it. Changes are shown at once and sent one at a
// time; what a gesture changes meanwhile replaces what waits, so that the last value wins.

import { History } from "./history.js";
import { difference, inverse, merge } from "./patch.js";
import { recall, remember } from "./store.js";

const CAMERA_REST_MS = 700;
const REFRESH_MS = 150;
const SETTINGS = "$settings"; // the key of a step that is no patch; a scene has none of this name

/**
 * Dispatches `change` when document, file or history have changed, and `settings` (detail: parameters
 * of render.set) when a step of settings is undone or redone.
 */
export class Scene extends EventTarget {
  #rpc;
  #fail;
  #history = new History();
  #queue = []; // {patch, group, passed} that wait
  #busy = false;
  #edits = 0; // a document that was asked for before an edit is out of date
  #refreshing;
  #camera; // the camera before it began to move
  #resting;

  document = null;
  file = undefined;
  bounds = null;

  /** @param fail called with the error of a call */
  constructor(rpc, fail) {
    super();
    this.#rpc = rpc;
    this.#fail = fail;
    rpc.addEventListener("scene", () => this.refreshSoon());
    rpc.addEventListener("open", () => this.refreshSoon());
  }

  get canUndo() {
    return this.#history.canUndo || this.#camera !== undefined;
  }

  get canRedo() {
    return this.#history.canRedo;
  }

  /**
   * Changes the scene by a merge patch. Changes of one group are one step of undo.
   * @param passed {files}: uploads that the patch names
   */
  change(patch, group, passed) {
    if (!this.document) return;
    this.#history.push({ undo: inverse(this.document, patch), redo: patch, group });
    this.#apply(patch, group, passed);
  }

  /** Keeps a change of settings for undo; both are parameters of render.set. */
  recordSettings(undo, redo, group) {
    this.#history.push({ undo: { [SETTINGS]: undo }, redo: { [SETTINGS]: redo }, group });
    this.#save();
    this.#tell();
  }

  async undo() {
    await this.#rest();
    this.#step(this.#history.undo());
  }

  redo() {
    this.#step(this.#history.redo());
  }

  #step(patch) {
    const detail = patch?.[SETTINGS];
    if (!detail) return this.#apply(patch);
    this.#save();
    this.#tell();
    this.dispatchEvent(new CustomEvent("settings", { detail }));
  }

  /** The camera moves by another way than change: what it was is kept for undo. */
  cameraMoves() {
    if (!this.document) return;
    if (this.#camera === undefined) {
      this.#camera = this.document.camera ?? null;
      this.#tell();
    }
    clearTimeout(this.#resting);
    this.#resting = setTimeout(() => this.#rest(), CAMERA_REST_MS);
  }

  /** Another scene was loaded: nothing of the old one can be undone. */
  forget() {
    this.#history.clear();
    this.#camera = undefined;
    this.#save();
  }

  refreshSoon() {
    this.#refreshing ??= setTimeout(() => {
      this.#refreshing = undefined;
      this.refresh();
    }, REFRESH_MS);
  }

  /** Asks the daemon for the scene. @returns whether the answer counts: nothing was changed meanwhile */
  async refresh() {
    const edits = this.#edits;
    const answer = this.#busy ? undefined : await this.#ask();
    if (this.#busy || edits !== this.#edits) {
      this.refreshSoon();
      return false;
    }
    if (answer) this.#take(answer);
    return true;
  }

  // Undefined if the connection ends: the next one asks again.
  #ask() {
    // an error of the daemon: nothing is shown, or the scene is too long to send
    return this.#rpc
      .call("scene.get")
      .catch((error) => (error.code === undefined ? undefined : {}));
  }

  #take({ scene, file, bounds }) {
    if (this.file === undefined) this.#restore(file);
    else if (file !== this.file) this.forget();
    Object.assign(this, { document: scene ?? null, file: file ?? null, bounds: bounds ?? null });
    this.#tell();
  }

  #apply(patch, group, passed) {
    if (!patch) return;
    this.#edits++;
    this.document = merge(this.document, patch);
    const last = this.#queue.at(-1);
    if (group !== undefined && last?.group === group) last.patch = patch;
    else this.#queue.push({ patch, group, passed });
    this.#save();
    this.#tell();
    this.#send();
  }

  async #send() {
    if (this.#busy) return;
    this.#busy = true;
    while (this.#queue.length) {
      const { patch, group, passed } = this.#queue.shift();
      try {
        await this.#rpc.call("scene.patch", { patch, ...passed });
        this.#fail();
      } catch (error) {
        this.#queue = [];
        this.#history.drop(group);
        this.#fail(error);
      }
    }
    this.#busy = false;
    this.refreshSoon();
  }

  // The camera has come to rest: its whole way is one step.
  async #rest() {
    clearTimeout(this.#resting);
    if (this.#camera === undefined) return;
    while (!(await this.refresh())) await new Promise((resolve) => setTimeout(resolve, REFRESH_MS));
    if (this.#camera === undefined) return; // another rest was quicker
    const before = { camera: this.#camera ?? {} },
      after = { camera: this.document?.camera ?? {} };
    this.#camera = undefined;
    const redo = difference(before, after);
    if (Object.keys(redo).length) this.#history.push({ undo: difference(after, before), redo });
    this.#save();
    this.#tell();
  }

  #save() {
    remember("history", { file: this.file, steps: this.#history.save() }, true);
  }

  #restore(file) {
    const kept = recall("history", {}, true);
    if (file !== undefined && kept.file === file) this.#history.restore(kept.steps);
  }

  #tell() {
    this.dispatchEvent(new Event("change"));
  }
}
