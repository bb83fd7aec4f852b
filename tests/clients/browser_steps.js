// The steps in Debian's Chromium: page.html from an origin that may call the gateway, and from one that may not.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createServer } from "node:http";
import { join, normalize } from "node:path";

import { startBrowser } from "../page/browser.js";
import { colour, quilt } from "./pictures.js";
import { PANEL, eventually } from "./world.js";

const TYPES = { html: "text/html", js: "text/javascript", mjs: "text/javascript" };

// page.html and the packages, at http://localhost:PORT.
export async function serve() {
  const server = createServer(async (request, answer) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    const file = path === "/" ? new URL("page.html", import.meta.url) : join(process.env.CLIENTS_NODE, path);
    const body = await readFile(file).catch(() => undefined);
    answer.writeHead(body ? 200 : 404, { "Content-Type": TYPES[path === "/" ? "html" : path.split(".").pop()] ?? "text/plain" });
    answer.end(body);
  });
  await new Promise((resolve) => server.listen(0, "localhost", resolve));
  return { origin: `http://localhost:${server.address().port}`, close: () => server.close() };
}

async function openPage(browser, origin) {
  const context = await browser.newContext();
  // it would ask for a permission and wait for ever; without it the panel is a popup to be moved
  await context.addInitScript(() => delete window.getScreenDetails);
  const page = await context.newPage();
  page.setDefaultTimeout(120000);
  await page.goto(origin);
  await page.waitForFunction(() => window.ready);
  return page;
}

async function seesThePanel(page) {
  await eventually(async () => {
    const { button, ...panel } = await page.evaluate(() => window.panel());
    assert.deepEqual(panel, { serial: PANEL.serial, width: PANEL.screenW.value, height: PANEL.screenH.value });
    assert.match(button, /looking glass/i);
  });
}

async function drawsForThePanel(page) {
  const popup = page.waitForEvent("popup");
  await page.getByRole("button", { name: /looking glass/i }).click();
  await popup;
  await eventually(async () => {
    const drawn = await page.evaluate(() => window.drawn());
    assert.ok(drawn, "the popup has a canvas");
    assert.equal(`${drawn.width}x${drawn.height}`, `${PANEL.screenW.value}x${PANEL.screenH.value}`);
    assert.ok(drawn.colours > 20, `${drawn.colours} colours`);
  });
}

export const browserSteps = [
  {
    name: "a WebXR page finds the panel",
    run: async (world) => {
      world.browser ??= await startBrowser();
      world.page = await openPage(world.browser, world.origin);
      await seesThePanel(world.page);
    },
  },
  { name: "it draws for the panel in its popup", run: async ({ page }) => drawsForThePanel(page) },
  {
    name: "a page with bridge.js casts a quilt",
    run: async (world) => {
      const page = await openPage(world.browser, world.origin);
      assert.equal(await page.evaluate((uri) => window.cast(uri), await world.file("page.png", quilt(120))), "cast");
      await eventually(async () => assert.deepEqual((await world.look()).at(3, 0.5), colour(120, 3)));
    },
  },
  {
    name: "a page of another origin reaches nothing",
    run: async (world) => {
      const page = await openPage(world.browser, world.otherOrigin);
      assert.equal(await page.evaluate((uri) => window.cast(uri), await world.file("other.png", quilt(80))), "not connected");
      assert.notEqual((await page.evaluate(() => window.panel())).serial, PANEL.serial);
      assert.deepEqual((await world.look()).at(3, 0.5), colour(120, 3));
    },
  },
];

// With --panel-only: the page has the panel, which quiltd has left.
export const panelOnlySteps = [
  {
    name: "--panel-only: quiltd leaves the panel",
    run: async (world) => eventually(async () => assert.equal((await world.quiltctl("status")).device.kind, "none")),
  },
  {
    name: "--panel-only: a WebXR page finds the panel",
    run: async (world) => {
      world.page = await openPage(world.browser, world.origin);
      await seesThePanel(world.page);
    },
  },
  { name: "--panel-only: it draws for the panel in its popup", run: async ({ page }) => drawsForThePanel(page) },
  {
    name: "--panel-only: quiltd opens the panel again at its end",
    run: async (world) => {
      await world.services.end();
      await eventually(async () => assert.equal((await world.quiltctl("status")).device.kind, "sim"));
    },
  },
];
