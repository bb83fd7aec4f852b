// The tab Scene: the tree, and what the chosen key means.

import { explain, make } from "./dom.js";
import { recall, remember } from "./store.js";
import { Tree } from "./tree.js";

export class SceneTab {
  #scene;
  #tree;
  element = make("div");

  constructor({ scene }) {
    this.#scene = scene;
    this.place = make("div", { id: "tree", class: "tree" });
    this.about = make(
      "p",
      { id: "about", class: "about" },
      "Drag a number to change it, or press it to type.",
    );
    this.none = make("p", { class: "hint", hidden: true }, "A finished image has no scene.");
    this.element.append(this.none, this.place);
    explain(this.place, this.about);
    scene.addEventListener("change", () => (this.none.hidden = scene.document !== null));
  }

  /** Whether the gateway has the schema. */
  async hello() {
    if (this.#tree) return true;
    const answer = await fetch("/scene.schema.json").catch(() => undefined);
    if (!answer?.ok) return false;
    const open = new Set(recall("open", ["/camera", "/lights"]));
    this.#tree = new Tree(await answer.json(), this.#scene, open, () =>
      remember("open", [...open]),
    );
    this.place.replaceChildren(this.#tree.element);
    return true;
  }
}
