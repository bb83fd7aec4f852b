// The scene as a tree of fields. A branch makes its rows when it is first opened, and keeps them: a
// change of the scene touches only what differs, so that the focus stays.

import { button, make, select } from "./dom.js";
import { makeField } from "./fields.js";
import { difference, patchAt, valueAt } from "./patch.js";
import * as schemas from "./schema.js";
import { freshGroup } from "./scrub.js";

const KIND_KEYS = ["type", "shape"]; // their words decide which other keys there are
const MATERIALS = "materials"; // id of the list of their names
const HIDDEN = ["$schema", "quiltd", "include"];

/** A scene tree. @param open a Set of the paths of open branches, which it changes */
export class Tree {
  /**
   * @param root the JSON Schema of scenes
   * @param scene a Scene
   * @param opened called when a branch is opened or closed
   */
  constructor(root, scene, open, opened) {
    Object.assign(this, { root, scene, open, opened });
    this.top = new Branch(this, [], root, true);
    this.names = make("datalist", { id: MATERIALS });
    this.element = make("div", {}, this.top.body, this.names);
    scene.addEventListener("change", () => this.update());
    this.update();
  }

  get materials() {
    return Object.keys(this.scene.document?.materials ?? {});
  }

  update() {
    if (!this.scene.document) return;
    this.top.update(this.scene.document);
    this.names.replaceChildren(...this.materials.map((value) => make("option", { value })));
  }

  /** A value for a new key; undefined: only a person knows one. */
  sample(key, schema) {
    return key === "material" ? this.materials[0] : schemas.sample(this.root, schema);
  }

  set(path, value, group) {
    this.scene.change(patchAt(path, value), group);
  }

  // Replaces an object, also keys that the new one lacks.
  replace(path, next) {
    const old = valueAt(this.scene.document, path);
    this.set(path, difference(old, next), freshGroup());
  }
}

const pointer = (path) =>
  path.map((key) => "/" + key.replaceAll("~", "~0").replaceAll("/", "~1")).join("");

function removal(tree, path) {
  const name = path.at(-1);
  return button("×", () => tree.set(path, null, freshGroup()), {
    class: "remove",
    "aria-label": `Remove ${name}`,
    title: `Remove ${name}`,
  });
}

// A row with a field of its own.
class Leaf {
  constructor(tree, path, schema, kind, value, required) {
    const name = path.at(-1);
    const range = schemas.rangeOf(tree.root, schema);
    this.kind = kind;
    this.field = makeField(
      kind,
      {
        label: name,
        range,
        list: name === "material" ? MATERIALS : undefined,
        bounded: schemas.variants(tree.root, schema).some((one) => one.colour && one.maximum === 1),
        words: schemas.variants(tree.root, schema).flatMap((one) => one.enum ?? []),
        commit: (next, group) => tree.set(path, next, group),
      },
      value,
    );
    const { unit } = schemas.resolve(tree.root, schema);
    this.element = make(
      "div",
      {
        class: "row",
        "data-path": pointer(path),
        "data-about": schemas.describe(tree.root, schema),
      },
      make("span", { class: "key" }, name),
      this.field.element,
      make("span", { class: "unit" }, unit === "degrees" ? "°" : ""),
      required ? null : removal(tree, path),
    );
  }

  update(value) {
    this.field.set(value);
  }
}

class Branch {
  #rows = new Map(); // key: Leaf or Branch
  #value;

  constructor(tree, path, schema, always) {
    this.kind = "object";
    this.tree = tree;
    this.path = path;
    this.schema = schema;
    this.body = make("div", { class: "branch" });
    this.more = make("div", { class: "more" });
    this.body.append(this.more);
    this.pointer = pointer(path);
    if (!always) this.#makeDetails();
    else this.isOpen = true;
  }

  #makeDetails() {
    this.note = make("span", { class: "note" });
    const about = schemas.describe(this.tree.root, this.schema);
    const summary = make(
      "summary",
      { "data-about": about },
      make("span", { class: "key" }, this.path.at(-1)),
      this.note,
    );
    this.isOpen = this.tree.open.has(this.pointer);
    this.element = make(
      "details",
      { "data-path": this.pointer, open: this.isOpen },
      summary,
      this.body,
    );
    this.element.addEventListener("toggle", () => {
      this.isOpen = this.element.open;
      this.tree.open[this.isOpen ? "add" : "delete"](this.pointer);
      this.tree.opened();
      this.update(this.#value);
    });
  }

  update(value) {
    this.#value = value;
    if (this.note) this.note.textContent = this.#summary(value);
    if (!this.isOpen) return;
    const variant = schemas.pick(this.tree.root, this.schema, value);
    const keys = Object.keys(value).filter(
      (key) => !(this.path.length === 0 && HIDDEN.includes(key)),
    );
    for (const [key, row] of this.#rows)
      if (!keys.includes(key)) {
        row.element.remove();
        this.#rows.delete(key);
      }
    keys.forEach((key, i) => this.#updateRow(key, i, value[key], variant));
    this.#updateMore(value, variant);
  }

  #summary(value) {
    const word =
      KIND_KEYS.map((key) => value[key]).find((one) => typeof one === "string") ??
      value.file?.split?.("/").pop();
    if (word) return word;
    const n = Object.keys(value).length;
    return this.schema.additionalProperties ? String(n) : "";
  }

  #schemaOf(key, variant) {
    return variant.properties?.[key] || variant.additionalProperties || {};
  }

  #updateRow(key, index, value, variant) {
    const schema = this.#schemaOf(key, variant),
      kind = this.#kindOf(key, schema, value);
    let row = this.#rows.get(key);
    if (row && row.kind !== kind) {
      row.element.remove();
      row = undefined;
    }
    if (!row) {
      row = this.#makeRow(key, schema, kind, value, variant);
      this.#rows.set(key, row);
      this.body.insertBefore(row.element, this.body.children[index]);
    }
    row.update(value);
  }

  // The length is part of the kind of a vector.
  #kindOf(key, schema, value) {
    const kind = this.#isKindKey(key) ? "kind" : schemas.fieldOf(this.tree.root, schema, value);
    return kind === "vector" ? `vector ${value.length}` : kind;
  }

  #isKindKey(key) {
    return (
      KIND_KEYS.includes(key) && schemas.choicesOf(this.tree.root, this.schema, key).length > 1
    );
  }

  #makeRow(key, schema, kind, value, variant) {
    const path = [...this.path, key],
      { tree } = this;
    if (kind === "object") return new Branch(tree, path, schemas.resolve(tree.root, schema));
    if (kind === "kind") return this.#makeKind(key);
    const leaf = new Leaf(
      tree,
      path,
      schema,
      kind.split(" ")[0],
      value,
      variant.required?.includes(key),
    );
    leaf.kind = kind;
    return leaf;
  }

  #makeKind(key) {
    const { root } = this.tree;
    const words = schemas.choicesOf(root, this.schema, key);
    const commit = (word) => {
      const next = schemas.retyped(root, this.schema, this.#value, key, word);
      if (next) this.tree.replace(this.path, next);
    };
    const field = makeField("choice", { label: key, words, commit });
    const about = schemas.describe(root, this.schema);
    const element = make(
      "div",
      { class: "row", "data-about": about },
      make("span", { class: "key" }, key),
      field.element,
    );
    return { kind: "kind", element, update: field.set };
  }

  // What can be added, and how the branch is removed.
  #updateMore(value, variant) {
    const missing = schemas
      .propertiesOf(variant)
      .filter(
        ([key, schema]) =>
          !(key in value) && !HIDDEN.includes(key) && this.tree.sample(key, schema) !== undefined,
      )
      .map(([key]) => key);
    const words = missing.join() + "|" + Boolean(variant.additionalProperties);
    if (this.words === words) return;
    this.words = words;
    const parts = [];
    if (missing.length) parts.push(this.#makeAdd(missing, variant));
    if (variant.additionalProperties) parts.push(this.#makeEntry(variant.additionalProperties));
    if (this.path.length)
      parts.push(
        button(`Remove ${this.path.at(-1)}`, () => this.tree.set(this.path, null, freshGroup()), {
          class: "quiet",
        }),
      );
    this.more.replaceChildren(...parts);
  }

  #makeAdd(keys, variant) {
    const list = select([["", "Add a key"], ...keys.map((key) => [key])], {
      "aria-label": `Add a key to ${this.path.at(-1) ?? "the scene"}`,
    });
    list.addEventListener("change", () => {
      const key = list.value,
        schema = this.#schemaOf(key, variant);
      list.value = "";
      this.#show(key);
      this.tree.set([...this.path, key], this.tree.sample(key, schema), freshGroup());
    });
    return list;
  }

  // A new object with a name, such as a light.
  #makeEntry(schema) {
    const { root } = this.tree;
    const key = KIND_KEYS.find((one) => schemas.choicesOf(root, schema, one).length);
    const words = key ? schemas.choicesOf(root, schema, key) : [];
    const samples = new Map();
    for (const word of words) samples.set(word, schemas.retyped(root, schema, {}, key, word));
    const kinds = words.filter((word) => samples.get(word));
    if (!kinds.length) return null;
    const list = select([["", "Add"], ...kinds.map((word) => [word])], {
      "aria-label": `Add to ${this.path.at(-1)}`,
    });
    list.addEventListener("change", () => {
      const name = this.#freeName(list.value);
      this.#show(name);
      this.tree.set([...this.path, name], samples.get(list.value), freshGroup());
      list.value = "";
    });
    return list;
  }

  #freeName(word) {
    for (let n = 1; ; n++) {
      const name = n === 1 ? word : `${word} ${n}`;
      if (!(name in this.#value)) return name;
    }
  }

  // What is added is shown open.
  #show(key) {
    this.tree.open.add(pointer([...this.path, key]));
    this.tree.opened();
  }
}
