// The tab Slideshow: scenes, models, quilts and videos that follow each other.

import { button, heading, labelled, make } from "./dom.js";
import { kindOf } from "./files.js";
import { scrub } from "./scrub.js";
import { fileName } from "./words.js";

const SECONDS = { minimum: 1, maximum: 86400 };
const FADE = { minimum: 0, maximum: 10 };
const USUAL_SECONDS = 20;

// Calls send when a gesture at a number has ended.
const settled = ({ element }, send) =>
  ["pointerup", "change", "keyup"].forEach((type) => element.addEventListener(type, send));

export class Slideshow {
  #rpc;
  #fail;
  #list = { entries: [], index: 0, playing: false, loop: true };
  #dragged; // index of the row that is dragged
  #told = 0; // crossfade that quiltd has
  #focus; // key of the button that follows its row to another place
  element = make("div");

  constructor({ rpc, fail }) {
    this.#rpc = rpc;
    this.#fail = fail;
    this.rows = make("ol", { id: "slides", class: "slides" });
    this.loop = make("input", { type: "checkbox", id: "loop" });
    this.loop.addEventListener("change", () => this.#setHow());
    this.play = button(
      "Play",
      () => this.#call(this.#list.playing ? "playlist.stop" : "playlist.play"),
      { id: "play", class: "main" },
    );
    const step = (text, method) => button(text, () => this.#call(method), { disabled: true });
    this.steps = [step("Previous", "playlist.previous"), step("Next", "playlist.next")];
    this.pause = button("Pause", () =>
      this.#call("playlist.pause", { paused: !this.#list.paused }),
    );
    this.fade = scrub({
      label: "Seconds of a crossfade",
      range: FADE,
      commit: (value) => (this.#list.crossfade = value),
    });
    settled(
      this.fade,
      () => this.#list.crossfade !== this.#told && this.#setHow(),
    );
    this.now = make("p", { class: "hint", role: "status" });
    this.empty = make(
      "p",
      { class: "hint" },
      "The slideshow is empty. Add entries in the tab Library, or drag them here.",
    );
    this.element.append(
      make(
        "section",
        {},
        heading("Slideshow"),
        make(
          "div",
          { class: "answers" },
          this.play,
          this.pause,
          ...this.steps,
        ),
        this.now,
        labelled("Start again at the end", this.loop),
        labelled("Crossfade in s", this.fade.element),
        this.rows,
        this.empty,
        make("p", { class: "hint" }, "The seconds of an entry count from its first image on. A video without them plays once."),
      ),
    );
    this.accept(this.element);
    rpc.addEventListener("playlist", ({ detail }) => this.#show(detail));
  }

  hello({ methods }) {
    const known = Boolean(methods["playlist.set"]);
    if (known) this.#call("playlist.get");
    return known;
  }

  status({ playlist, video }) {
    if (!playlist?.playing) this.now.textContent = "";
    else
      this.now.textContent =
        `Entry ${playlist.index + 1} of ${playlist.entries}: ${fileName(playlist.file)}` +
        (playlist.paused ? ", paused" : "") +
        (video ? `, ${video.shown} frames shown, ${video.dropped} dropped` : "");
  }

  /** Adds a file, or plays a folder.
   * @returns a promise of the list with the entry; undefined: refused */
  add({ path, kind }) {
    const { entries, seconds, crossfade } = this.#list;
    if (kind === "folder")
      return this.#call("playlist.set", { folder: path, seconds, crossfade }).then(
        (list) => list && this.#call("playlist.play"),
      );
    const own = kind === "video" ? {} : { seconds: USUAL_SECONDS };
    return this.#set([...entries, { file: path, ...own }]);
  }

  #call(method, params = {}) {
    this.#fail();
    return this.#rpc.call(method, params).then((list) => {
      this.#show(list);
      this.#fail();
      return list;
    }, this.#fail);
  }

  #set(entries) {
    return this.#setHow({ entries });
  }

  // The same entries otherwise; a folder stays one, which quiltd reads again.
  #setHow(source) {
    const { folder, entries, seconds, crossfade } = this.#list;
    const what = source ?? (folder ? { folder } : { entries });
    return this.#call("playlist.set", { ...what, loop: this.loop.checked, seconds, crossfade });
  }

  #show(list) {
    const focus =
      this.#focus ?? document.activeElement?.closest?.("#slides li button")?.dataset.key;
    this.#focus = undefined;
    this.#list = list;
    this.loop.checked = list.loop;
    this.play.textContent = list.playing ? "Stop" : "Play";
    this.pause.textContent = list.paused ? "Go on" : "Pause";
    this.pause.disabled = !list.playing;
    this.#told = list.crossfade;
    this.fade.set(list.crossfade);
    for (const one of [this.play, ...this.steps]) one.disabled = list.entries.length === 0;
    this.empty.hidden = list.entries.length > 0;
    if (!this.rows.querySelector(":focus.scrub, .dragged"))
      this.rows.replaceChildren(...list.entries.map((entry, i) => this.#row(entry, i)));
    if (focus) this.#focusOn(focus);
  }

  // A button that is disabled now gives the focus to the row's name.
  #focusOn(key) {
    const one = this.rows.querySelector(`[data-key="${key}"]`);
    (one?.disabled ? one.closest("li").querySelector("button") : one)?.focus();
  }

  #row({ file, seconds }, i) {
    const name = file.split("/").pop(),
      { entries, index, playing } = this.#list;
    const time = scrub({
      label: `Seconds of ${name}`,
      range: SECONDS,
      commit: (value) => (entries[i] = { ...entries[i], seconds: value }),
    });
    const once = seconds === undefined && kindOf(name) === "video";
    time.set(once ? undefined : (seconds ?? this.#list.seconds));
    if (once) time.element.placeholder = "once";
    settled(
      time,
      () =>
        entries[i].seconds !== seconds &&
        this.#call("playlist.change", { index: i, seconds: entries[i].seconds }),
    );
    const move = (text, words, to) =>
      button(text, () => this.#move(i, to, text), {
        class: "quiet",
        "aria-label": `${words} ${name}`,
        "data-key": `${text}${i}`,
        disabled: to < 0 || to >= entries.length,
      });
    const row = make(
      "li",
      { draggable: "true", "aria-current": playing && i === index ? "true" : undefined },
      make("span", { class: "grip", title: "Drag to another place" }, String(i + 1)),
      button(name, () => this.#call("playlist.play", { index: i }), {
        class: "quiet name",
        title: file,
        "data-key": `name${i}`,
      }),
      time.element,
      make("span", { class: "unit" }, "s"),
      move("Up", "Move up", i - 1),
      move("Down", "Move down", i + 1),
      button("×", () => this.#set(entries.filter((_, k) => k !== i)), {
        class: "remove",
        "aria-label": `Remove ${name}`,
      }),
    );
    row.addEventListener("keydown", (event) => this.#moveByKey(event, i));
    row.addEventListener("dragstart", () => (this.#dragged = i));
    row.addEventListener("dragend", () => (this.#dragged = undefined));
    return row;
  }

  #moveByKey(event, i) {
    const way = event.altKey ? { ArrowUp: -1, ArrowDown: 1 }[event.key] : undefined;
    if (!way) return;
    event.preventDefault();
    this.#move(i, i + way, "name");
  }

  // button: which of the row's buttons gets the focus
  #move(from, to, button) {
    const entries = [...this.#list.entries];
    if (to < 0 || to >= entries.length) return;
    if (button) this.#focus = button + to;
    entries.splice(to, 0, ...entries.splice(from, 1));
    return this.#set(entries);
  }

  /** Takes what is dropped on an element: rows that change their place, and entries of the library. */
  accept(element) {
    element.addEventListener("dragover", (event) => {
      if (this.#dragged !== undefined || event.dataTransfer.types.includes("application/x-quiltd"))
        event.preventDefault();
    });
    element.addEventListener("drop", (event) => {
      const row = event.target.closest("#slides li");
      const to = row ? [...this.rows.children].indexOf(row) : this.#list.entries.length - 1;
      if (this.#dragged !== undefined) this.#move(this.#dragged, to);
      else {
        const entry = event.dataTransfer.getData("application/x-quiltd");
        if (!entry) return;
        this.add(JSON.parse(entry));
      }
      event.preventDefault();
    });
  }
}
