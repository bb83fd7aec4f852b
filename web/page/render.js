// The settings of rendering: render.set, and what the controls show meanwhile.

import { Held } from "./held.js";
import { latest } from "./latest.js";

// What is not undone: it says nothing about the image.
const PASSING = ["paused"];

/** The settings of a status, by their names in render.set. */
function settingsOf(status) {
  const { exposure } = status;
  const stops = exposure?.auto ? "auto" : exposure?.stops;
  return { ...status, exposure: stops };
}

export class Render {
  #held = new Held();
  #send;
  #scene;
  #now = {}; // the settings that are shown

  /**
   * @param scene a Scene, whose history takes the changes
   * @param fail called with the error of a call, or nothing
   */
  constructor(rpc, scene, fail) {
    this.#scene = scene;
    scene.addEventListener("settings", ({ detail }) => this.#apply(detail));
    this.#send = latest((params) =>
      rpc.call("render.set", params).then(
        () => {
          this.#held.answered(this.#shown(params));
          fail();
        },
        (error) => {
          this.#held.refused(this.#shown(params));
          fail(error);
        },
      ),
    );
  }

  /** Sets parameters of render.set. Changes of one group are one step of undo. */
  set(params, group) {
    const keys = Object.keys(params).filter((key) => !PASSING.includes(key));
    const undo = Object.fromEntries(keys.map((key) => [key, this.#before(key)]));
    if (keys.length && Object.values(undo).every((value) => value !== undefined))
      this.#scene.recordSettings(undo, params, group);
    this.#apply(params);
  }

  // What undo is to set. An exposure that is the scene's stays the scene's.
  #before(key) {
    const now = this.#now[key];
    return key === "exposure" && now === this.#own() ? "scene" : now;
  }

  #own() {
    return this.#scene.document?.film?.exposure ?? 0;
  }

  // The values that a status will have.
  #shown(params) {
    return params.exposure === "scene" ? { ...params, exposure: this.#own() } : params;
  }

  #apply(params) {
    const shown = this.#shown(params);
    for (const [key, value] of Object.entries(shown)) this.#held.set(key, value);
    this.#now = { ...this.#now, ...shown };
    this.#send(params);
  }

  /** The settings of a status, with those that a person has just set. Once for each status. */
  follow(status) {
    const all = Object.entries(settingsOf(status));
    this.#now = Object.fromEntries(all.map(([key, value]) => [key, this.#held.show(key, value)]));
    return this.#now;
  }
}
