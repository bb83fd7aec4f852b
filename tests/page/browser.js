// Debian's Chromium with the page of a quiltweb of the test's own, and what the page did. QUILTD_BUILD has the programs,
// QUILTD_NODE the packages.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

import { start } from "../../clients/js/tests/live.js";

const require = createRequire(join(process.env.QUILTD_NODE, "package.json"));
const { chromium } = require("playwright-core");
const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

export const VIEWS = 9;
export const SCENE = {
  quiltd: 1,
  camera: { views: VIEWS, cone: 35, position: [0, 0, 6], target: [0, 0, 0], fov_y: 24 },
  materials: { clay: { albedo: [0.7, 0.35, 0.2] } },
  meshes: { cube: { shape: "cube", material: "clay", transform: { rotate: [0, 30, 0], scale: 0.6 } } },
  volumes: { fog: { shape: "sphere", density: 0.8, albedo: 0.9 } },
  lights: { sky: { type: "environment", radiance: 0.7 }, lamp: { type: "point", position: [2, 3, 2], intensity: 8 } },
};

// A quiltd that shows SCENE on a simulated panel of 96 x 128 pixels.
export function startQuiltd() {
  const calibration = readFileSync(new URL("../scenes/panel.json", import.meta.url));
  const options = ["--device", "sim:sim", "--view-size", "120x160", "--threads", "1", "--run-for", "1800"];
  return start({ document: SCENE, options, files: { "sim/calibration.json": calibration } });
}

export function startBrowser() {
  const root = process.getuid() === 0 ? ["--no-sandbox"] : [];
  const software = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"];
  return chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: [...root, ...software] });
}

// The canvas keeps what was drawn, so that a test can read it later.
function keepDrawings() {
  const getContext = HTMLCanvasElement.prototype.getContext;
  HTMLCanvasElement.prototype.getContext = function (kind, options) {
    return getContext.call(this, kind, { ...options, preserveDrawingBuffer: true });
  };
}

// What a page did.
export class Watch {
  requests = []; // URLs
  errors = []; // of the console, and those that nobody caught
  bytes = 0; // bodies of HTTP
  open = 0; // requests that have no whole answer
  sent = []; // messages of the WebSocket: { method, params }
  images = []; // generations of the images
  answers = new Map(); // method of a call by its id
  refused = []; // methods of calls that got an error

  constructor(page) {
    page.on("request", (request) => {
      this.requests.push(request.url());
      this.open++;
    });
    page.on("requestfailed", () => this.open--);
    page.on("console", (message) => message.type() === "error" && this.errors.push(message.text()));
    page.on("pageerror", (error) => this.errors.push(String(error)));
    page.on("requestfinished", async (request) => {
      const { responseBodySize } = await request.sizes().catch(() => ({ responseBodySize: 0 }));
      this.bytes += responseBodySize;
      this.open--;
    });
    page.on("websocket", (socket) => {
      this.requests.push(socket.url());
      socket.on("framesent", ({ payload }) => this.#sent(JSON.parse(payload)));
      socket.on("framereceived", ({ payload }) => this.#received(payload));
    });
  }

  #sent(message) {
    this.sent.push(message);
    this.answers.set(message.id, message.method);
  }

  #received(payload) {
    if (typeof payload !== "string") return this.images.push(payload.readUInt32LE(0));
    const { id, error } = JSON.parse(payload);
    if (error) this.refused.push(this.answers.get(id));
  }

  // The sum of a parameter over all calls of a method.
  sum(method, name) {
    const calls = this.sent.filter((message) => message.method === method);
    return calls.reduce((sum, { params }) => sum + (params[name] ?? 0), 0);
  }
}

// A window without a token. { page, watch }
export async function newPage(browser) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, reducedMotion: "reduce" });
  await context.addInitScript(keepDrawings);
  const page = await context.newPage();
  page.setDefaultTimeout(120000);
  return { page, watch: new Watch(page) };
}

// Until the page shows this generation or a later one.
export function shown(page, generation) {
  const isShown = (wanted) => Number(document.getElementById("preview").dataset.generation) >= wanted;
  return page.waitForFunction(isShown, generation);
}

// Two frames of the browser: what was asked for is drawn.
export function drawn(page) {
  return page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
}

// What is on the canvas: the number of colours, and a sum that differs from picture to picture.
export async function readCanvas(page) {
  await drawn(page);
  return page.evaluate(() => {
    const gl = document.getElementById("preview").getContext("webgl2");
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const words = new Uint32Array(pixels.buffer);
    return { colours: new Set(words).size, sum: words.reduce((sum, word) => (31 * sum + word) % 2147483647, width) };
  });
}

// Serious and critical findings of axe, as lines.
export async function findings(page) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate("axe.run(document, { resultTypes: ['violations'] })");
  const bad = violations.filter(({ impact }) => ["serious", "critical"].includes(impact));
  return bad.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.map(({ target }) => target).join(", ")}`);
}
