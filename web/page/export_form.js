// The tab Export: what to write, its options, and the jobs with their downloads.

import { button, explain, fill, heading, labelled, make, select } from "./dom.js";
import {
  EXPORTS,
  jobText,
  kindsOf,
  LABELS,
  nameFor,
  parametersOf,
  valueOf,
} from "./exports.js";
import { proofView } from "./proof.js";
import { recall, remember } from "./store.js";
import { bytesText } from "./words.js";

const MOST_NOTES = 5; // of a job

// A field for a parameter of the schema; a default stands in it as a placeholder.
function fieldFor(key, schema) {
  const id = `export-${key}`;
  if (schema.type === "boolean")
    return make("input", { type: "checkbox", id, checked: Boolean(schema.default) });
  if (schema.enum) {
    const list = select(
      schema.enum.map((word) => [word]),
      { id },
    );
    list.value = schema.default ?? schema.enum[0];
    return list;
  }
  const usual = schema.default ?? /\(([^()]*)\)$/.exec(schema.description)?.[1] ?? "";
  return make("input", {
    type: "text",
    class: "text",
    id,
    placeholder: String(usual),
    autocomplete: "off",
  });
}

export class ExportForm {
  #rpc;
  #fail;
  #photo = false; // a finished image is shown
  #status = {};
  #parameters = {};
  #fields = new Map();
  #kept = recall("exports", {}); // what was chosen, by kind and field
  #jobs = new Map(); // number: {element, bar, text, cancel, notes}
  element = make("div");

  constructor({ rpc, fail }) {
    this.#rpc = rpc;
    this.#fail = fail;
    this.kind = select([], { id: "export-kind" });
    this.kind.addEventListener("change", () => this.#showKind());
    this.what = make("p", { class: "hint" });
    this.about = make("p", { class: "about" });
    this.ending = select([], { id: "export-ending" });
    this.wait = select(
      [
        ["coarse", "now"],
        ["complete", "when complete"],
        ["converged", "at the error to reach"],
      ],
      { id: "export-wait" },
    );
    this.options = make("div", { class: "options" });
    this.start = button("Export", () => this.#start(), { id: "export-start", class: "main" });
    this.jobs = make("ul", { id: "jobs", class: "jobs" });
    this.element.append(
      make(
        "section",
        {},
        heading("What"),
        labelled("Kind", this.kind),
        this.what,
        labelled("File type", this.ending),
        labelled("Write", this.wait),
        this.options,
        this.start,
      ),
      make("section", {}, heading("Jobs"), this.jobs),
    );
    this.element.addEventListener("change", () => this.#keep());
    explain(this.options, this.about);
    rpc.addEventListener("export", ({ detail }) => this.#follow(detail));
    rpc.addEventListener("log", ({ detail }) => this.#hear(detail));
    rpc.addEventListener("download", ({ detail }) => this.#download(detail));
  }

  /** Whether quiltd and quiltweb offer exports. */
  hello({ methods }) {
    this.#parameters = methods.export?.params.properties ?? {};
    const kinds = kindsOf(this.#parameters);
    fill(
      this.kind,
      kinds.map((kind) => [kind, EXPORTS[kind].name]),
    );
    const kept = recall("export");
    if (kinds.includes(kept)) this.kind.value = kept;
    if (kinds.length) this.#showKind();
    return kinds.length > 0;
  }

  status(status) {
    this.#status = status;
    const photo = Boolean(status.is_quilt);
    if (photo === this.#photo) return;
    this.#photo = photo;
    if (this.kind.value) this.#showKind();
  }

  // A reload finds all fields as they were.
  #keep() {
    const values = { ending: this.ending.value };
    for (const [key, { field }] of this.#fields)
      values[key] = field.type === "checkbox" ? field.checked : field.value;
    this.#kept = { ...this.#kept, wait: this.wait.value, [this.kind.value]: values };
    remember("exports", this.#kept);
  }

  #recall() {
    const kept = this.#kept[this.kind.value] ?? {};
    const fields = [...this.#fields].map(([key, { field }]) => [key, field]);
    for (const [key, field] of [["ending", this.ending], ...fields]) {
      const value = kept[key];
      if (typeof value === "boolean") field.checked = value;
      else if (value !== undefined && (!field.options || [...field.options].some((one) => one.value === value)))
        field.value = value;
    }
    this.wait.value = this.#kept.wait ?? "coarse";
  }

  #showKind() {
    const kind = this.kind.value,
      { about, endings } = EXPORTS[kind];
    remember("export", kind);
    this.what.textContent = about;
    this.about.textContent = "";
    fill(
      this.ending,
      endings.map((one) => [one]),
    );
    this.ending.parentElement.hidden = endings.length < 2;
    this.#fields.clear();
    const lines = parametersOf(kind, this.#parameters, this.#photo).map(([key, schema, needed]) => {
      const field = fieldFor(key, schema);
      this.#fields.set(key, { field, schema, needed });
      const line = labelled(
        LABELS[key],
        field,
        make("span", { class: "unit" }, schema.unit ?? ""),
      );
      line.dataset.about = schema.description;
      if (needed) field.required = true;
      return line;
    });
    this.options.replaceChildren(...lines);
    this.#recall();
  }

  #start() {
    this.#fail();
    const kind = this.kind.value;
    const params = {
      kind,
      file: nameFor(kind, this.#status, this.ending.value),
      wait: this.wait.value,
    };
    for (const [key, { field, schema, needed }] of this.#fields) {
      const value = valueOf(schema, field.type === "checkbox" ? field.checked : field.value);
      if (needed && value === undefined) return field.focus();
      if (value !== undefined && value !== schema.default) params[key] = value;
    }
    this.#rpc.call("export", params).then(({ job, file, warnings = [] }) => {
      this.#job(job, file);
      for (const text of warnings) this.#note(job, text);
    }, this.#fail);
  }

  #job(job, file = "") {
    if (!this.#jobs.has(job)) {
      const bar = make("progress", { max: "1", value: "0", "aria-label": `Progress of ${file}` });
      const text = make("span", { class: "note" }, "waits");
      const cancel = button("Cancel", () =>
        this.#rpc.call("job.cancel", { job }).catch(this.#fail),
      );
      const notes = make("ul");
      const element = make(
        "li",
        { "data-job": job },
        make("span", { class: "name" }, file.split("/").filter(Boolean).pop()),
        bar,
        text,
        cancel,
        notes,
      );
      this.#jobs.set(job, { element, bar, text, cancel, notes });
      this.jobs.prepend(element);
    }
    return this.#jobs.get(job);
  }

  #follow({ job, file, state, progress, error, farm }) {
    const { bar, text, cancel } = this.#job(job, file);
    bar.value = progress ?? 0;
    text.textContent = jobText(state, error, farm);
    cancel.hidden = bar.hidden = state !== "running" && state !== "waiting";
  }

  #note(job, text) {
    const { notes } = this.#jobs.get(job);
    const said = [...notes.children].map((one) => one.textContent);
    if (said.length < MOST_NOTES && !said.includes(text))
      notes.append(make("li", { class: "finding", "data-level": "note" }, text));
  }

  // What is logged while a job runs may be about it.
  #hear({ level, text }) {
    if (level !== "warning") return;
    for (const [job, { cancel }] of this.#jobs) if (!cancel.hidden) this.#note(job, text);
  }

  // The links stay; the first file of a job is fetched at once.
  #download({ job, files }) {
    const { element } = this.#job(job, files[0]?.name);
    const links = files.map(({ name, bytes, path }) =>
      make(
        "a",
        { href: path, download: name.split("/").pop() },
        `Save ${name} (${bytesText(bytes)})`,
      ),
    );
    element.append(...links);
    if (/_proof\.png$/.test(files[0]?.name)) return element.append(proofView(files[0].path));
    if (links.length <= 2) links.forEach((link) => link.click());
  }
}
