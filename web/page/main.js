// Connects the parts of the page.

import { at } from "./dom.js";
import { ExportForm } from "./export_form.js";
import { Health } from "./health.js";
import { Library } from "./library.js";
import { Picture } from "./picture.js";
import { Remaining } from "./remaining.js";
import { Render } from "./render.js";
import { Rpc } from "./rpc.js";
import { Scene } from "./scene.js";
import { SceneTab } from "./scene_tab.js";
import { Slideshow } from "./slideshow.js";
import { acceptFiles, makeSheet, Stage } from "./stage.js";
import { makeTabs } from "./tabs.js";
import { filesOf } from "./upload.js";
import { describe, fileName } from "./words.js";

const STATUS_MS = 1000;
const rpc = new Rpc();
globalThis.quiltd = rpc; // for the console: await quiltd.call("camera.orbit", { yaw: 15 })
const notices = { link: "", trouble: "", scene: "", card: "" };
const WRONG_TOKEN = "This token is not valid any more. Open the URL that quiltweb printed last.";
let wrong = false; // the token of the URL was refused
let dismissed = ""; // the words that a person has taken away

// The token of the URL becomes a cookie, and leaves the address bar, also if it is refused.
async function exchangeToken() {
  const token = location.hash.slice(1);
  if (!token) return;
  const headers = { Authorization: `Bearer ${token}` };
  const answer = await fetch("/api/login", { method: "POST", headers });
  wrong = answer.status === 401 || answer.status === 403;
  if (answer.ok || wrong) history.replaceState(null, "", location.pathname);
}

// Shows a notice of one kind in place of the one before; an empty text ends it.
function notify(kind, text = "") {
  notices[kind] = text;
  showNotices();
}

const wordsOfNotices = () => [...new Set(Object.values(notices).filter(Boolean))].join(" ");

// What was dismissed stays away until other words come. Folders of uploads say nothing to a person.
function showNotices() {
  const words = wordsOfNotices();
  if (words !== dismissed) dismissed = "";
  const text = dismissed ? "" : words.replaceAll(/\/upload\/[0-9a-f]+\//g, "");
  if (at("notice").textContent !== text) at("notice").textContent = text;
  at("notices").hidden = text === "";
}

function dismiss() {
  dismissed = wordsOfNotices();
  showNotices();
}

// The error of a call; without one, the last call has succeeded.
const complain = (error) => notify("trouble", error?.message);

// Why there is no connection.
async function explain(reason) {
  const answer = await fetch("/api/status").catch(() => undefined);
  const words = {
    401: wrong
      ? WRONG_TOKEN
      : "This page has no token. Open the URL that quiltweb printed when it started.",
    503: `quiltd does not answer${reason ? ` (${reason})` : ""}. This page connects as soon as it does.`,
  };
  if (!answer) return "quiltweb has ended. This page connects when it runs again.";
  return words[answer.status] ?? "";
}

class Page {
  constructor() {
    const scene = new Scene(rpc, complain);
    const context = {
      rpc,
      fail: complain,
      scene,
      render: new Render(rpc, scene, complain),
      queue: (entry) => this.slideshow.add(entry),
    };
    this.scene = context.scene;
    this.render = context.render;
    this.stage = new Stage(context);
    this.picture = new Picture(context);
    this.library = new Library(context);
    this.slideshow = new Slideshow(context);
    this.exports = new ExportForm(context);
    this.health = new Health(context);
    this.tree = new SceneTab(context);
    this.#makeTabs();
    this.#makeButtons();
    acceptFiles(async (transfer) => {
      const files = await filesOf(transfer);
      this.showTab("library");
      this.library.take(files);
    });
    this.remaining = new Remaining();
    this.#follow();
  }

  #makeTabs() {
    const raise = makeSheet(at("side"), at("sheet"));
    const tab = (id, name, part) => ({ id, name, part, panel: part.element });
    const tabs = [
      tab("picture", "Picture", this.picture),
      tab("scene", "Scene", this.tree),
      tab("library", "Library", this.library),
      tab("slideshow", "Slideshow", this.slideshow),
      tab("export", "Export", this.exports),
      tab("health", "Health", this.health),
    ];
    at("panels").append(...tabs.map(({ panel }) => panel));
    at("side").append(this.tree.about, this.exports.about);
    this.showTab = makeTabs(at("tabs"), tabs, (id) => {
      this.tab = id;
      for (const { id: one, part } of tabs) if (part.about) part.about.hidden = one !== id;
      complain(); // what went wrong belongs to the tab before
      tabs.find((one) => one.id === id).part.shown?.();
    });
    at("tabs").addEventListener("click", raise);
    this.slideshow.accept(at("tab-slideshow"));
  }

  #makeButtons() {
    at("fit").addEventListener("click", () => {
      this.scene.cameraMoves();
      rpc.call("camera.fit").then(() => complain(), complain);
    });
    at("pause").addEventListener("click", ({ currentTarget }) => {
      const paused = currentTarget.getAttribute("aria-pressed") !== "true";
      currentTarget.setAttribute("aria-pressed", String(paused));
      this.render.set({ paused });
    });
    at("undo").addEventListener("click", () => this.scene.undo());
    at("redo").addEventListener("click", () => this.scene.redo());
    this.scene.addEventListener("change", () => {
      at("undo").disabled = !this.scene.canUndo;
      at("redo").disabled = !this.scene.canRedo;
    });
    at("dismiss").addEventListener("click", dismiss);
    addEventListener("keydown", (event) => this.#undoByKey(event));
  }

  // A text that is being typed has an undo of its own.
  #undoByKey(event) {
    if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
    if (event.target.matches?.("input.text")) return;
    event.preventDefault();
    if (event.shiftKey) this.scene.redo();
    else this.scene.undo();
  }

  #follow() {
    rpc.addEventListener("frame", ({ detail }) =>
      notify("card", detail.card && `The panel shows a card: ${detail.card}`),
    );
    rpc.addEventListener("open", () => this.#open().catch(complain));
    rpc.addEventListener("close", async ({ detail }) => {
      for (const control of [this.stage.slider, at("fit"), at("pause")]) control.disabled = true;
      at("progress").textContent = "";
      const words = await explain(detail);
      complain();
      notify("link", words);
      this.health.connected(false, words);
    });
    this.#followStatus();
    rpc.connect();
  }

  async #open() {
    notify("link");
    complain();
    this.health.connected(true);
    this.stage.connected();
    const hello = await rpc.call("hello");
    const wanted = ["frame", "scene", "device", "export", "log", "playlist"];
    const known = Object.values(hello.events).map(({ event }) => event);
    await rpc.call("subscribe", { events: wanted.filter((event) => known.includes(event)) });
    this.picture.hello(hello);
    this.library.hello(hello);
    this.health.hello(hello);
    this.#offer("export", this.exports.hello(hello));
    this.#offer("slideshow", this.slideshow.hello(hello));
    this.#offer("scene", await this.tree.hello());
    if (this.tab === "library") this.library.shown();
    if (this.tab === "health") this.health.shown();
  }

  // Hides a tab that this quiltd has nothing for.
  #offer(id, yes) {
    at(`tab-${id}`).hidden = !yes;
    if (!yes && this.tab === id) this.showTab("picture");
  }

  async #followStatus() {
    if (!document.hidden)
      await rpc.call("status").then(
        (status) => this.#status(status),
        () => {},
      );
    setTimeout(() => this.#followStatus(), STATUS_MS);
  }

  #status(status) {
    const settings = this.render.follow(status);
    const left = this.remaining.take(status);
    const waits = this.stage.waits(status);
    at("progress").textContent = describe(status, left, waits);
    at("scene").textContent = `${waits ? "loading " : ""}${fileName(status.scene)}`;
    at("scene").title = status.scene ?? "";
    at("pause").setAttribute("aria-pressed", String(Boolean(settings.paused)));
    at("fit").disabled = !status.scene || status.is_quilt;
    at("pause").disabled = !status.scene || (status.is_quilt && !status.video);
    notify("scene", status.error?.message);
    for (const part of [this.stage, this.picture, this.slideshow, this.exports, this.health])
      part.status(status, settings, left);
  }
}

// Another token was pasted into the address bar.
addEventListener("hashchange", () => location.reload());
exchangeToken()
  .then(() => new Page())
  .catch(complain);
