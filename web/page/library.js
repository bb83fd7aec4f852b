// The tab Library: folders that quiltd may read, and files of this computer.

import { at, button, heading, make } from "./dom.js";
import { environmentPatch, kindOf, mainOf, mayName, notesOn, saysAll, tilesOf } from "./files.js";
import { patiently } from "./patiently.js";
import { freshGroup } from "./scrub.js";
import { recall, remember } from "./store.js";
import { Cancelled, nameOf, upload } from "./upload.js";
import { bytesText, count } from "./words.js";

const MOST_TEXT = 64 << 20; // bytes of files that may name others
const WITH_THUMBNAIL = ["quilt", "image"];
const KIND_WORDS = {
  folder: "folder",
  scene: "scene",
  model: "model",
  volume: "volume",
  environment: "light",
  quilt: "quilt",
  video: "video",
  image: "photo",
};

const sign = (kind) => make("span", { class: "sign" }, KIND_WORDS[kind] ?? kind);

// An image as a canvas; undefined: refused. The rules of the page allow no images of blobs.
async function drawn(src) {
  const blob = await patiently(() => fetch(src));
  if (!blob) return undefined;
  const bitmap = await createImageBitmap(blob);
  const { width, height } = bitmap;
  const canvas = make("canvas", { width, height, "aria-hidden": "true" });
  canvas.getContext("2d").drawImage(bitmap, 0, 0);
  return canvas;
}

function thumbnail({ path, kind }) {
  const src = `/api/thumbnail?${new URLSearchParams({ file: path, width: "160" })}`;
  const image = make("img", { src, alt: "", loading: "lazy", draggable: "false" });
  image.addEventListener("error", async () => {
    const later = await drawn(src).catch(() => undefined);
    image.replaceWith(later ?? sign(kind));
  });
  return image;
}

// The contents of the files that may name others; undefined: they are long.
async function textsOf(files) {
  const some = files.filter((file) => mayName(nameOf(file)));
  if (files.length < 2 || some.reduce((sum, { size }) => sum + size, 0) > MOST_TEXT) return undefined;
  return Promise.all(some.map(async (file) => (await file.text()).toLowerCase()));
}

export class Library {
  #rpc;
  #scene;
  #fail;
  #queue; // called with an entry: puts it into the slideshow, and answers the list
  #folder = recall("folder", undefined);
  #places = new Map(); // how far each folder is scrolled
  #known = false; // quiltd has library.list
  element = make("div");

  constructor({ rpc, scene, fail, queue }) {
    this.#rpc = rpc;
    this.#scene = scene;
    this.#fail = fail;
    this.#queue = queue;
    this.path = make("nav", { class: "path", "aria-label": "Folder" });
    this.list = make("ul", { id: "entries", class: "entries" });
    this.task = make("div", { id: "task", class: "task" });
    this.picker = make("input", {
      type: "file",
      id: "files",
      multiple: true,
      class: "unseen",
      "aria-label": "Files to show",
    });
    this.picker.addEventListener("change", () => this.take([...this.picker.files]));
    this.element.append(
      make(
        "section",
        {},
        heading("From this computer"),
        make(
          "p",
          { class: "hint" },
          "Drop models, volumes, light, quilts, photos or videos onto the page, with the files that belong to them.",
        ),
        make("label", { class: "file", for: "files" }, "Choose files"),
        this.picker,
        this.task,
      ),
      make("section", { id: "folders" }, heading("Folders of quiltd"), this.path, this.list),
    );
  }

  hello({ methods, folders }) {
    this.#known = Boolean(methods["library.list"]);
    this.slideshow = Boolean(methods["playlist.set"]);
    at("folders").hidden = !this.#known || folders?.[0] === "/dev/null";
  }

  shown() {
    if (this.#known) this.#open(this.#folder);
  }

  async #open(folder) {
    try {
      const list = await this.#rpc.call("library.list", folder === undefined ? {} : { folder });
      const scroller = this.element.parentElement,
        place = scroller.scrollTop,
        same = folder === this.#folder;
      this.#show(list);
      if (!this.element.hidden) {
        if (!same) this.#places.set(this.#folder, place);
        scroller.scrollTop = same ? place : (this.#places.get(folder) ?? 0);
      }
      this.#folder = folder;
      remember("folder", folder);
    } catch (error) {
      if (folder === undefined) this.#fail(error);
      else this.#open(undefined);
    }
  }

  #show({ folder, folders, entries, more }) {
    const root = folders
      .filter((one) => folder === one || folder?.startsWith(one + "/"))
      .sort((a, b) => b.length - a.length)[0];
    const steps = root ? folder.slice(root.length).split("/").filter(Boolean) : [];
    const crumbs = [["All folders", undefined]];
    if (root) crumbs.push([root.split("/").pop() || "/", root]);
    steps.forEach((name, i) => crumbs.push([name, [root, ...steps.slice(0, i + 1)].join("/")]));
    this.path.replaceChildren(
      ...crumbs.map(([name, path], i) =>
        button(name, () => this.#open(path), {
          class: "quiet",
          "aria-current": i === crumbs.length - 1 ? "true" : undefined,
        }),
      ),
    );
    this.list.replaceChildren(...entries.map((entry) => this.#item(entry)));
    if (more)
      this.list.append(
        make("li", { class: "hint" }, "This folder has more entries. quiltd lists the first 1000."),
      );
    if (!entries.length)
      this.list.append(make("li", { class: "hint" }, "Nothing here that quiltd can show."));
  }

  #item(entry) {
    const { name, kind, bytes } = entry;
    const picture = WITH_THUMBNAIL.includes(kind) ? thumbnail(entry) : sign(kind);
    const note =
      kind === "folder" ? "folder" : `${KIND_WORDS[kind] ?? kind}, ${bytesText(bytes ?? 0)}`;
    const about = make("span", { class: "note", "aria-live": "polite" }, note);
    const open = make(
      "button",
      {
        type: "button",
        class: "entry",
        "data-kind": kind,
        title: name,
        onclick: () => this.#choose(entry),
      },
      picture,
      make("span", { class: "name" }, name),
      about,
    );
    const item = make("li", {}, open);
    if (this.slideshow && kind !== "environment")
      this.#makeMovable(item, open, entry, about);
    return item;
  }

  // about: where the answer to Add is told
  #makeMovable(item, open, entry, about) {
    open.draggable = true;
    open.addEventListener("dragstart", (event) =>
      event.dataTransfer.setData("application/x-quiltd", JSON.stringify(entry)),
    );
    item.append(
      entry.kind === "folder"
        ? button("Play", () => this.#add(entry, about), {
            class: "quiet add whole",
            "aria-label": `Play ${entry.name} as a slideshow`,
          })
        : button("Add", () => this.#add(entry, about), {
            class: "quiet add",
            "aria-label": `Add ${entry.name} to the slideshow`,
          }),
    );
  }

  async #add(entry, about) {
    const list = await this.#queue(entry);
    const words = count(list?.entries.length, "entry", "entries");
    if (list) about.textContent = entry.kind === "folder" ? `plays ${words}` : `added, ${words}`;
  }

  async #choose({ name, path, kind }) {
    if (kind === "folder") return this.#open(path);
    this.#fail();
    const plan = await this.#plan(name, kind);
    if (plan) await this.#use(plan, path, {});
  }

  /**
   * What is to be done with a file, by its kind, or as the person says.
   * @returns {light: true}, parameters of scene.load, or undefined: nothing
   */
  async #plan(name, kind) {
    if (kind === "environment") return this.#planLight(name);
    const asks = (kind === "image" || kind === "video") && !saysAll(name);
    return asks ? this.#planImage(name, kind === "video" ? "Video" : "Photo") : {};
  }

  async #planLight(name) {
    const answers = [...(this.#scene.document ? ["Light of this scene"] : []), "Photo", "Cancel"];
    const answer = answers[await this.#ask(`What is ${name}?`, answers)];
    if (answer === "Photo") return { quilt: "1x1" };
    return answer === "Cancel" ? undefined : { light: true };
  }

  async #planImage(name, word) {
    const tiles = make("input", {
      type: "text",
      class: "text",
      placeholder: "columns x rows, such as 8x6",
      "aria-label": "Columns and rows of the quilt",
    });
    const answer = await this.#ask(
      `What is ${name}?`,
      [word, `${word} with depth at its right`, "Quilt of these tiles", "Cancel"],
      tiles,
    );
    if (answer === 0) return { quilt: "1x1" };
    if (answer === 1) return { rgbd_in: "right" };
    if (answer === 3) return undefined;
    const quilt = tilesOf(tiles.value);
    if (!quilt)
      this.#fail({ message: `${name}: the tiles of a quilt are columns x rows, such as 8x6.` });
    return quilt && { quilt };
  }

  // Shows a file as planned. passed: {files} of an upload; notes: sentences for the person.
  #use({ light, ...how }, file, passed, notes = []) {
    if (!light) return this.#load({ file, ...how, ...passed }, notes);
    this.#scene.change(environmentPatch(this.#scene.document, file), freshGroup(), passed);
  }

  #load(params, notes) {
    return this.#rpc.call("scene.load", params).then(({ warnings }) => {
      this.#scene.forget();
      const words = [...(warnings?.length ? [`${warnings.join(". ")}.`] : []), ...notes];
      this.#fail(words.length ? { message: words.join(" ") } : undefined);
    }, this.#fail);
  }

  // A question with buttons. Resolves to the index of the one that was pressed.
  #ask(text, answers, field) {
    return new Promise((resolve) => {
      const end = (i) => {
        this.task.replaceChildren();
        resolve(i);
      };
      const row = make(
        "div",
        { class: "answers" },
        ...answers.map((answer, i) => button(answer, () => end(i))),
      );
      this.task.replaceChildren(make("p", {}, text), ...(field ? [field] : []), row);
      row.firstChild.focus();
    });
  }

  /** Shows files of this computer. */
  async take(files) {
    this.picker.value = "";
    if (!files.length) return;
    this.#fail();
    const main = mainOf(files.map(nameOf));
    if (!main)
      return this.#fail({
        message: `${nameOf(files[0])}: quiltd does not know this kind of file.`,
      });
    const plan = await this.#plan(main, kindOf(main));
    if (!plan) return;
    const stop = new AbortController();
    try {
      const progress = this.#progress(`Sending ${main}`, () => stop.abort());
      const paths = await upload(files, progress, stop.signal);
      this.#progress(`quiltd reads ${main}`);
      const notes = notesOn(files.map(nameOf), main, await textsOf(files));
      await this.#use(plan, paths[files.map(nameOf).indexOf(main)], { files: paths }, notes);
    } catch (error) {
      if (!(error instanceof Cancelled)) this.#fail({ message: `${main}: ${error.message}.` });
    } finally {
      this.task.replaceChildren();
    }
  }

  // Without a stop there is no share either.
  #progress(text, stop) {
    const bar = make("progress", { max: "1", "aria-label": text });
    this.task.replaceChildren(make("p", {}, text), bar, ...(stop ? [button("Cancel", stop)] : []));
    return (share) => bar.setAttribute("value", share);
  }
}
