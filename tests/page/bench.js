// Times of the page, as medians, for a machine that does nothing else: make bench-page. BENCH_SCENE: the scene; BENCH_RUNS (9).

import { startBrowser, newPage, shown } from "./browser.js";
import { start } from "../../clients/js/tests/live.js";

const RUNS = Number(process.env.BENCH_RUNS ?? 9);
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];

// In the page: when it draws, and how many frames of the browser there were before.
function countFrames() {
  window.frames_ = 0;
  window.draws = [];
  const tick = () => requestAnimationFrame(() => (window.frames_++, tick()));
  tick();
  const { drawArrays } = WebGL2RenderingContext.prototype;
  WebGL2RenderingContext.prototype.drawArrays = function (...words) {
    window.draws.push({ at: performance.now(), frame: window.frames_ });
    return drawArrays.apply(this, words);
  };
}

// Milliseconds until the first paint of a new window.
async function firstPaint(browser, url) {
  const { page } = await newPage(browser);
  await page.goto(url);
  await shown(page, 0);
  const paints = await page.evaluate(() => performance.getEntriesByType("paint").map(({ name, startTime }) => [name, startTime]));
  await page.context().close();
  return Object.fromEntries(paints)["first-contentful-paint"];
}

// From a move of the mouse to the drawing of the view below it: milliseconds, and frames of the browser.
async function anotherView(page, x, y) {
  await page.evaluate(() => {
    window.draws.length = 0;
    document.getElementById("preview").addEventListener("pointermove", () => {
      window.moved = { at: performance.now(), frame: window.frames_ };
    }, { once: true, capture: true });
  });
  await page.mouse.move(x, y);
  await page.waitForFunction(() => window.draws.some(({ at }) => window.moved && at >= window.moved.at));
  return page.evaluate(() => {
    const draw = window.draws.find(({ at }) => at >= window.moved.at);
    return { ms: draw.at - window.moved.at, frames: draw.frame - window.moved.frame };
  });
}

// Milliseconds from the last move of a drag until the panel shows it.
async function panelAfterDrag(q, page, x, y) {
  const { generation } = await q.status();
  const frames = q.events("frame");
  await page.mouse.move(x, y);
  await page.mouse.down();
  const begin = performance.now();
  await page.mouse.move(x + 20, y);
  for await (const { params } of frames) if (params.generation > generation) break;
  const took = performance.now() - begin;
  await page.mouse.up();
  await q.wait("complete");
  return took;
}

async function repeat(measure) {
  const values = [];
  for (let i = 0; i < RUNS; i++) values.push(await measure(i));
  return values;
}

// The simulated panel is that of quiltd's usual calibration, the view size the one for it.
const live = await start({ scene: process.env.BENCH_SCENE, options: ["--device", "sim:panel", "--run-for", "1800"] });
const browser = await startBrowser();
try {
  await live.q.wait("complete");
  const paint = await repeat(() => firstPaint(browser, live.url));
  const { page } = await newPage(browser);
  await page.addInitScript(countFrames);
  await page.goto(live.url);
  await shown(page, 0);
  const { x, y, width, height } = await page.locator("#preview").boundingBox();
  const drags = await repeat(() => panelAfterDrag(live.q, page, x + width / 2, y + height / 2));
  await live.q.render.set({ paused: true }); // nothing else is drawn
  await shown(page, (await live.q.status()).generation);
  const views = await repeat((i) => anotherView(page, x + width * (0.2 + (0.6 * (i % 5)) / 5), y + height / 2));
  const line = (what, value, asked) => console.log(`${what.padEnd(42)} ${value.padStart(9)}   ${asked}`);
  line(`median of ${RUNS}`, "", "asked");
  line("panel after a drag", `${(median(drags) / 1000).toFixed(2)} s`, "0.6 s");
  line("preview of another view", `${median(views.map(({ frames }) => frames))} frames`, "1");
  line("", `${median(views.map(({ ms }) => ms)).toFixed(0)} ms`, "");
  line("first paint", `${(median(paint) / 1000).toFixed(2)} s`, "0.3 s");
} finally {
  await browser.close();
  await live.stop();
}
