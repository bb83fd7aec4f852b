// The tab Health: what doctor finds, the panel, and what was logged.

import { button, heading, make } from "./dom.js";
import { count, sortFindings } from "./words.js";

const MOST_LINES = 200;
const LEVELS = { ok: "fine", note: "note", fail: "wrong" };

function finding({ level, text }) {
  return make(
    "li",
    { class: "finding", "data-level": level },
    make("strong", {}, LEVELS[level] ?? level),
    " ",
    text,
  );
}

export class Health {
  #rpc;
  #fail;
  #methods = {};
  #found = []; // of doctor
  #kind; // of the device
  element = make("div");

  constructor({ rpc, fail }) {
    this.#rpc = rpc;
    this.#fail = fail;
    this.link = make("p", { id: "link", class: "finding" });
    this.panel = make("dl", { id: "device" });
    this.warnings = make("ul", { id: "warnings", class: "findings" });
    this.findings = make("ul", { id: "findings", class: "findings" });
    this.lines = make("ol", { id: "log", class: "log", tabindex: "0", "aria-label": "Log" });
    this.summary = make("summary");
    this.aside = make("ul", { class: "findings" });
    this.folded = make("details", { id: "hardware", hidden: true }, this.summary, this.aside);
    this.doctor = make(
      "section",
      { hidden: true },
      heading("Check"),
      this.findings,
      this.folded,
      button("Check again", () => this.shown()),
    );
    this.log = make("section", { hidden: true }, heading("Log"), this.lines);
    this.element.append(
      make("section", {}, heading("Connection"), this.link),
      make("section", {}, heading("Panel"), this.panel),
      make("section", {}, heading("This image"), this.warnings),
      this.doctor,
      this.log,
    );
    rpc.addEventListener("log", ({ detail }) => this.#add([detail]));
    this.connected(false);
  }

  connected(yes, words) {
    this.link.dataset.level = yes ? "ok" : "fail";
    this.link.textContent = yes
      ? "This page is connected to quiltd."
      : words || "This page is not connected to quiltd.";
  }

  hello({ methods, name, version }) {
    this.#methods = methods;
    this.link.textContent = `This page is connected to ${name} ${version}.`;
    this.doctor.hidden = !methods.doctor;
    this.log.hidden = !methods["log.tail"];
    if (!this.log.hidden)
      this.#rpc.call("log.tail").then(
        ({ lines }) => {
          this.lines.replaceChildren();
          this.#add(lines);
        },
        () => (this.log.hidden = true),
      );
  }

  shown() {
    this.#fail();
    if (this.#methods.doctor)
      this.#rpc
        .call("doctor")
        .then(({ findings }) => {
          this.#found = findings;
          this.#showFindings();
        }, this.#fail);
  }

  #showFindings() {
    const { shown, folded } = sortFindings(this.#found, this.#kind);
    this.findings.replaceChildren(...shown.map(finding));
    this.aside.replaceChildren(...folded.map(finding));
    this.summary.textContent = `${count(folded.length, "note")} about hardware`;
    this.folded.hidden = folded.length === 0;
  }

  #add(lines) {
    for (const { time, level, text } of lines) {
      const clock = new Date(time * 1000).toLocaleTimeString("en-GB");
      this.lines.prepend(make("li", { "data-level": level }, make("time", {}, clock), " ", text));
    }
    while (this.lines.children.length > MOST_LINES) this.lines.lastChild.remove();
  }

  status({ device = {}, warnings = [], error, landlock }) {
    if (this.#kind !== device.kind) {
      this.#kind = device.kind;
      this.#showFindings();
    }
    const rows = [
      ["Model", device.present ? device.model || device.kind : "none"],
      ["Serial", device.serial],
      ["Calibration", device.calibration_from],
      ["Output", device.output],
      ["Problem", device.problem],
      [
        "File readers",
        { on: "confined", refused: "confined by seccomp alone", off: "confined by seccomp alone" }[
          landlock
        ],
      ],
    ];
    this.panel.replaceChildren(
      ...rows
        .filter(([, value]) => value)
        .flatMap(([key, value]) => [make("dt", {}, key), make("dd", {}, value)]),
    );
    const said = [
      ...(error ? [{ level: "fail", text: error.message }] : []),
      ...warnings.map((text) => ({ level: "note", text })),
    ];
    if (!said.length) said.push({ level: "ok", text: "Nothing to report." });
    const words = JSON.stringify(said);
    if (this.words !== words) this.warnings.replaceChildren(...said.map(finding));
    this.words = words;
  }
}
