// Values that a person has set, until the status of the daemon has them.

const MOST_STATUSES = 5; // that differ after the answer: somebody else has set another value

export class Held {
  #values = new Map(); // key: { value, answered, statuses }

  /** A person has set a value; a call will say so to the daemon. */
  set(key, value) {
    this.#values.set(key, { value, answered: false, statuses: 0 });
  }

  /** The daemon has taken these values. A later one than that stays as it is. */
  answered(values) {
    for (const [key, value] of Object.entries(values)) {
      const held = this.#values.get(key);
      if (held?.value === value) held.answered = true;
    }
  }

  /** The daemon has refused these values. */
  refused(values) {
    for (const [key, value] of Object.entries(values))
      if (this.#values.get(key)?.value === value) this.#values.delete(key);
  }

  /** The value to show when a status has this one. A status may be older than the answer of a call. */
  show(key, value) {
    const held = this.#values.get(key);
    if (!held) return value;
    if (!held.answered) return held.value;
    held.statuses++;
    if (held.value !== value && held.statuses <= MOST_STATUSES) return held.value;
    this.#values.delete(key);
    return value;
  }
}
