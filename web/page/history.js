// What can be undone and redone: steps of two merge patches.

const MOST_STEPS = 100;
const MOST_CHARACTERS = 1 << 20;

export class History {
  #done = [];
  #undone = [];

  get canUndo() {
    return this.#done.length > 0;
  }

  get canRedo() {
    return this.#undone.length > 0;
  }

  /**
   * Records a step.
   * @param step {undo, redo, group}: patches. Steps of one group, such as a drag, are one step; they
   * set the same keys.
   */
  push({ undo, redo, group }) {
    const last = this.#done.at(-1);
    this.#undone = [];
    if (group !== undefined && last?.group === group) last.redo = redo;
    else this.#done.push({ undo, redo, group });
    if (this.#done.length > MOST_STEPS) this.#done.shift();
  }

  /** Forgets the last step if it is of this group: it was refused. */
  drop(group) {
    if (group !== undefined && this.#done.at(-1)?.group === group) this.#done.pop();
  }

  /** The patch that undoes the last step, or undefined. */
  undo() {
    const step = this.#done.pop();
    if (step) this.#undone.push(step);
    return step?.undo;
  }

  redo() {
    const step = this.#undone.pop();
    if (step) this.#done.push(step);
    return step?.redo;
  }

  clear() {
    this.#done = [];
    this.#undone = [];
  }

  /** A text for restore; without the oldest steps if it would be long. */
  save() {
    for (let from = 0; ; from = from * 2 + 1) {
      const strip = ({ undo, redo }) => ({ undo, redo });
      const done = this.#done.slice(from).map(strip);
      const text = JSON.stringify({ done, undone: from ? [] : this.#undone.map(strip) });
      if (text.length <= MOST_CHARACTERS || done.length === 0) return text;
    }
  }

  restore(text) {
    const { done, undone } = JSON.parse(text);
    this.#done = done;
    this.#undone = undone;
  }
}
