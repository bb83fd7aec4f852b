// The settings of rendering: render.set, and what the controls show meanwhile.

import { Held } from "./held.js";
import { latest } from "./latest.js";

/** The settings of a status, by their names in render.set. */
function settingsOf(status) {
  const { exposure } = status;
  const stops = exposure?.auto ? "auto" : exposure?.stops;
  return { ...status, exposure: stops };
}

export class Render {
  #held = new Held();
  #send;

  /** @param fail called with the error of a call, or nothing */
  constructor(rpc, fail) {
    this.#send = latest((params) =>
      rpc.call("render.set", params).then(
        () => {
          this.#held.answered(params);
          fail();
        },
        (error) => {
          this.#held.refused(params);
          fail(error);
        },
      ),
    );
  }

  /** Sets parameters of render.set. */
  set(params) {
    for (const [key, value] of Object.entries(params)) this.#held.set(key, value);
    this.#send(params);
  }

  /** The settings of a status, with those that a person has just set. Once for each status. */
  follow(status) {
    const all = Object.entries(settingsOf(status));
    return Object.fromEntries(all.map(([key, value]) => [key, this.#held.show(key, value)]));
  }
}
