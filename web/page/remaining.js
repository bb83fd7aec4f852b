// The time left, as far as it can be told: estimates from few passes jump by factors.

import { duration, secondsLeft } from "./words.js";

const FEWEST_PASSES = 8;
const ESTIMATES = 6; // of which the middle one counts
const SPREAD = 1.5; // largest ratio of the longest to the shortest

export class Remaining {
  #estimates = []; // ends, in seconds of rendering
  #generation;

  /** @returns words on the time left, "" if it is not known well enough. Once for each status. */
  take(status) {
    if (status.state === "paused") return "paused";
    if (status.state === "converged") return "done: the error is below the target";
    const seconds = this.#follow(status);
    return seconds === undefined ? "" : `${duration(seconds)} left`;
  }

  #follow(status) {
    const key = `${status.generation} ${status.target_error}`;
    if (key !== this.#generation) this.#estimates = [];
    this.#generation = key;
    const left = secondsLeft(status);
    if (status.state !== "rendering" || left === undefined || !(status.passes >= FEWEST_PASSES)) {
      this.#estimates = [];
      return undefined;
    }
    this.#estimates.push(left + status.seconds);
    if (this.#estimates.length > ESTIMATES) this.#estimates.shift();
    if (this.#estimates.length < ESTIMATES) return undefined;
    const lefts = this.#estimates.map((end) => Math.max(end - status.seconds, 0.5));
    lefts.sort((a, b) => a - b);
    if (lefts.at(-1) / lefts[0] > SPREAD) return undefined;
    return lefts[ESTIMATES >> 1];
  }
}
