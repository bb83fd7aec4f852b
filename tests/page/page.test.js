// The page in a browser: what a person does with it, in the order of a visit. No test asserts how long something takes.

import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";

import { SCENE, VIEWS, findings, newPage, readCanvas, shown, startBrowser, startQuiltd } from "./browser.js";
import { makePyramid } from "./glb.js";

const TABS = ["picture", "scene", "library", "slideshow", "export", "health"];
const MODES = ["view", "parallel", "crossed", "anaglyph", "quilt", "panel"];
const DEGREES_PER_PIXEL = 0.35;
const MOST_BYTES = 200000;
const screenshots = join(process.env.QUILTD_NODE, "..", "page");

let quiltd, browser, page, watch, failed = false;

// A step of the visit. After one that fails, the others say nothing.
const step = (name, body) =>
  it(name, async (test) => {
    if (failed) return test.skip("an earlier step failed");
    failed = true;
    await body();
    failed = false;
  });
const at = (selector) => page.locator(selector);
// Those that this quiltd has something for.
const tabs = () => TABS.filter((name) => name !== "slideshow" || quiltd.q.info.methods["playlist.set"]);
const tab = (name) => at(`#tab-${name}`).click();
const notice = () => at("#notice").textContent();

// Waits for what comes to hold at some time; the limit is there for a page that never comes to it.
async function until(holds) {
  for (let i = 0; i < 6000; i++) {
    if (await holds()) return;
    await page.waitForTimeout(20);
  }
  assert.fail(`it never came to hold: ${holds}`);
}
const sceneNow = async () => (await quiltd.q.scene.get()).scene;

// The panel and the preview show the newest generation, which is returned.
async function settled() {
  const { generation } = await quiltd.q.wait("complete");
  await shown(page, generation);
  return generation;
}

// Rendering stops, and the preview has come to its last image.
async function still() {
  await settled();
  await quiltd.q.render.set({ paused: true });
  let same = 0, last;
  await until(async () => {
    const { sum } = await readCanvas(page);
    same = sum === last ? same + 1 : 0;
    last = sum;
    return same === 10;
  });
}

async function drag(what, dx, dy, steps) {
  await what.hover(); // scrolls until nothing covers it
  const box = await what.boundingBox();
  const x = Math.round(box.x + box.width / 2), y = Math.round(box.y + box.height / 2);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= steps; i++) await page.mouse.move(x + (dx * i) / steps, y + (dy * i) / steps);
  await page.mouse.up();
}

// Drops files { name, data } on the page.
async function drop(files) {
  await page.evaluate((all) => {
    const transfer = new DataTransfer();
    for (const { name, base64 } of all)
      transfer.items.add(new File([Uint8Array.from(atob(base64), (c) => c.charCodeAt(0))], name));
    for (const type of ["dragover", "drop"])
      document.body.dispatchEvent(new DragEvent(type, { dataTransfer: transfer, bubbles: true, cancelable: true }));
  }, files.map(({ name, data }) => ({ name, base64: Buffer.from(data).toString("base64") })));
}

before(async () => {
  [quiltd, browser] = await Promise.all([startQuiltd(), startBrowser()]);
  ({ page, watch } = await newPage(browser));
});
after(async () => {
  await browser?.close();
  await quiltd?.stop();
});

describe("the page", () => {
  step("opens by its URL, and takes the token out of the address", async () => {
    await page.goto(quiltd.url);
    await settled();
    assert.equal(new URL(page.url()).hash, "");
    assert.match(await at("#view-number").textContent(), new RegExp(`of ${VIEWS}$`));
    await until(async () => (await at("#scene").textContent()) === "scene.json");
  });

  step("says that a token is wrong, and takes it out of the address", async () => {
    const other = await newPage(browser);
    await other.page.goto(`${new URL(quiltd.url).origin}/#${"0".repeat(64)}`);
    await other.page.getByText("This token is not valid any more. Open the URL that quiltweb printed last.").first().waitFor();
    assert.equal(new URL(other.page.url()).hash, "");
    await other.page.context().close();
  });

  step("has less than 200 kB in all its tabs", async () => {
    for (const name of tabs()) await tab(name);
    await until(() => watch.open === 0);
    assert.ok(watch.bytes > 20000 && watch.bytes < MOST_BYTES, `${watch.bytes} bytes`);
  });

  step("draws something in every mode, in each something else", async () => {
    await still();
    const sums = new Map();
    for (const mode of MODES) {
      await at("#mode").selectOption(mode);
      await until(async () => (await readCanvas(page)).colours > 50);
      const { sum } = await readCanvas(page);
      assert.equal(sums.get(sum), undefined, `${mode} looks like ${sums.get(sum)}`);
      sums.set(sum, mode);
    }
    await at("#mode").selectOption("view");
  });

  step("draws another view under the pointer, without asking for it", async () => {
    const box = await at("#preview").boundingBox();
    const before = watch.sent.filter(({ method }) => method !== "status" && method !== "preview.ack").length;
    await page.mouse.move(box.x + 0.1 * box.width, box.y + box.height / 2);
    const left = await readCanvas(page);
    assert.match(await at("#view-number").textContent(), /^View 1 of/);
    await page.mouse.move(box.x + 0.9 * box.width, box.y + box.height / 2);
    assert.match(await at("#view-number").textContent(), new RegExp(`^View ${VIEWS} of`));
    assert.notEqual((await readCanvas(page)).sum, left.sum);
    const after = watch.sent.filter(({ method }) => method !== "status" && method !== "preview.ack").length;
    assert.equal(after, before);
    await quiltd.q.render.set({ paused: false });
  });
});

describe("a drag", () => {
  let first, from;
  step("turns the camera by all of its steps", async () => {
    first = await settled();
    from = await sceneNow();
    watch.sent.length = watch.images.length = 0;
    await drag(at("#preview"), 120, -40, 30);
    const near = (a, b) => Math.abs(a - b) < 1e-6;
    await until(async () => near(watch.sum("camera.orbit", "yaw"), -120 * DEGREES_PER_PIXEL));
    assert.ok(near(watch.sum("camera.orbit", "pitch"), -40 * DEGREES_PER_PIXEL));
  });

  step("changes what the panel shows, and the preview after it, in order", async () => {
    const generation = await settled();
    const calls = watch.sent.filter(({ method }) => method === "camera.orbit").length;
    // one for each call, and none from elsewhere
    assert.equal(generation, first + calls);
    const { shown: panel } = await quiltd.q.status();
    assert.equal(panel.generation, generation);
    assert.equal(Number(await at("#preview").getAttribute("data-generation")), generation);
    assert.ok(watch.images.length > 0 && watch.images.at(-1) === generation, `${watch.images}`);
    assert.deepEqual(watch.images, [...watch.images].sort((a, b) => a - b));
  });

  step("leaves the camera where its angle says", async () => {
    const { position } = (await sceneNow()).camera;
    const angle = ([x, , z]) => (Math.atan2(x, z) * 180) / Math.PI;
    assert.ok(Math.abs(angle(position) - angle(from.camera.position) + 120 * DEGREES_PER_PIXEL) < 1e-3, position);
  });

  step("is one step of undo", async () => {
    await until(() => at("#undo").isEnabled());
    await at("#undo").click();
    await until(async () => JSON.stringify(await sceneNow()) === JSON.stringify(from));
  });
});

describe("the tree of the scene", () => {
  let original;
  const field = (pointer) => at(`[data-path="${pointer}"] input.scrub`).first();
  const open = async (pointer) => {
    const branch = at(`details[data-path="${pointer}"]`);
    if ((await branch.getAttribute("open")) === null) await branch.locator("> summary").click();
  };

  step("has values that can be dragged", async () => {
    await tab("scene");
    original = await sceneNow();
    for (const [branch, name, dx] of [["/lights/lamp", "intensity", 60], ["/camera", "fov_y", -40]]) {
      if (branch.startsWith("/lights")) await open("/lights");
      await open(branch);
      const number = field(`${branch}/${name}`);
      const value = Number(await number.inputValue());
      await drag(number, dx, 0, 12);
      const dragged = Number(await number.inputValue());
      assert.ok(dx > 0 ? dragged > value : dragged < value, `${name}: ${value} became ${dragged}`);
      const steps = branch.slice(1).split("/");
      await until(async () => Math.abs(steps.reduce((to, key) => to[key], await sceneNow())[name] - dragged) < 1e-3 * dragged);
    }
    await settled();
  });

  step("undoes a drag by one step each, to the same scene", async () => {
    for (let i = 0; i < 2; i++) {
      await until(() => at("#undo").isEnabled());
      await at("#undo").click();
    }
    await until(async () => JSON.stringify(await sceneNow()) === JSON.stringify(original));
    assert.equal(await at("#redo").isEnabled(), true);
  });

  step("redoes what was undone, also after a reload, which keeps the rest, too", async () => {
    await at("#redo").click();
    await until(async () => (await sceneNow()).lights.lamp.intensity !== original.lights.lamp.intensity);
    const changed = await sceneNow();
    await at("#mode").selectOption("anaglyph");
    const number = await at("#view-number").textContent();
    await page.reload();
    await settled();
    assert.deepEqual(await sceneNow(), changed);
    assert.equal(await at("#mode").inputValue(), "anaglyph");
    assert.equal(await at("#view-number").textContent(), number);
    assert.equal(await at("#tab-scene").getAttribute("aria-selected"), "true");
    await until(() => field("/lights/lamp/intensity").isVisible());
    await until(() => at("#undo").isEnabled());
    await at("#undo").click();
    await until(async () => JSON.stringify(await sceneNow()) === JSON.stringify(original));
    await at("#mode").selectOption("view");
  });
});

describe("files of the person", () => {
  step("are shown when they are dropped", async () => {
    await drop([{ name: "pyramid.glb", data: makePyramid([0.1, 0.6, 0.2]) }]);
    await until(async () => /^\/upload\/[^/]+\/pyramid\.glb$/.test((await quiltd.q.status()).scene));
    await settled();
    assert.equal(await notice(), "");
    await until(async () => (await at("#scene").textContent()) === "pyramid.glb");
    assert.ok((await readCanvas(page)).colours > 50);
  });

  step("that are wrong are refused in words, and the image stays", async () => {
    const { scene } = await quiltd.q.status();
    const wrong = [
      ["broken.glb", makePyramid([1, 0, 0]).subarray(0, 300), /broken\.glb/],
      ["noise.vdb", Buffer.from("no volume at all"), /noise\.vdb/],
      ["letter.docx", Buffer.from("text"), /letter\.docx: quiltd does not know this kind of file/],
      ["scene.json", Buffer.from('{"quiltd":1,"lights":{"a":{"type":"moon"}}}'), /moon|lights/],
    ];
    for (const [name, data, words] of wrong) {
      await drop([{ name, data }]);
      await until(async () => words.test(await notice()));
    }
    assert.ok(!(await notice()).includes("/upload/"));
    await at("#dismiss").click();
    assert.equal(await notice(), "");
    assert.equal((await quiltd.q.status()).scene, scene);
  });

  step("leave no error behind when the tab changes", async () => {
    await drop([{ name: "letter.docx", data: Buffer.from("text") }]);
    await until(async () => /letter\.docx/.test(await notice()));
    await tab("picture");
    assert.equal(await notice(), "");
  });
});

describe("the other tabs", () => {
  const slides = () => at("#slides li .name").allTextContents();

  step("export a file, which arrives by itself", async () => {
    await tab("export");
    const download = page.waitForEvent("download", { timeout: 120000 });
    await at("#export-start").click();
    assert.equal((await download).suggestedFilename(), "pyramid.png");
    await until(async () => /done/.test(await at("#jobs li").first().textContent()));
  });

  step("name a quilt by its tiles", async () => {
    const { columns, rows } = await quiltd.q.status();
    await at("#export-kind").selectOption("quilt");
    const download = page.waitForEvent("download", { timeout: 120000 });
    await at("#export-start").click();
    assert.match((await download).suggestedFilename(), new RegExp(`^pyramid_qs${columns}x${rows}a0\\.75\\.png$`));
  });

  step("show a print through its sheet, with a slider for the eye", async () => {
    await at("#export-kind").selectOption("proof");
    for (const [key, value] of [["lpi", "60"], ["width", "20"], ["height", "30"]])
      await at(`#export-${key}`).fill(value);
    await at("#export-start").click();
    const seen = at("#jobs .proof img").first();
    await until(async () => (await seen.count()) && /translate/.test(await seen.getAttribute("style") ?? ""));
    const box = await at("#jobs .proof .seen").first().boundingBox();
    assert.ok(Math.abs(box.width / box.height - 20 / 30) < 0.05);
    const words = () => at("#jobs .proof output").first().textContent();
    const place = () => seen.evaluate((element) => element.style.translate);
    assert.equal(await words(), "in the middle");
    const middle = await place();
    await at("#jobs .proof input").first().fill("24");
    assert.equal(await words(), "beyond the jump");
    assert.notEqual(await place(), middle);
  });

  step("keep the fields of an export after a reload, and cover none by its help", async () => {
    await at("#export-kind").selectOption("print");
    await at("#export-lpi").fill("60.5");
    await at("#export-compress").selectOption("lzw");
    await page.reload();
    await settled();
    await until(async () => (await at("#export-lpi").inputValue()) === "60.5");
    assert.equal(await at("#export-kind").inputValue(), "print");
    assert.equal(await at("#export-compress").inputValue(), "lzw");
    assert.equal(await at("#export-photo").count(), 0);
    await at("#export-marks").focus();
    const help = await at("#side > .about:visible").boundingBox();
    const panels = await at("#panels").boundingBox();
    assert.ok(help.height > 20 && help.y >= panels.y + panels.height - 1);
  });

  step("show the folders of quiltd, and make a slideshow of their files", async () => {
    await tab("slideshow");
    for (const name of ["Play", "Previous", "Next"])
      assert.equal(await at("#panel-slideshow").getByRole("button", { name, exact: true }).isEnabled(), false);
    await tab("library");
    await at('#entries [data-kind="folder"]').first().click();
    const add = at("#entries .add:not(.whole)").first();
    for (let n = 1; n <= 3; n++) {
      await add.click();
      await until(async () => (await quiltd.q.call("playlist.get")).entries.length === n);
      const words = n === 1 ? "added, 1 entry" : `added, ${n} entries`;
      await until(async () => (await add.locator("xpath=..").textContent()).includes(words));
    }
    await tab("slideshow");
    await until(async () => (await slides()).length === 3);
    const seconds = at("#slides .scrub").nth(2);
    await seconds.fill("7");
    await seconds.press("Enter");
    await until(async () => (await quiltd.q.call("playlist.get")).entries[2].seconds === 7);
  });

  step("change the order by drag and by keys, and the focus follows", async () => {
    const order = async () => (await quiltd.q.call("playlist.get")).entries.map((entry) => entry.seconds === 7);
    await at("#slides .grip").nth(2).dragTo(at("#slides .grip").nth(0));
    await until(async () => (await order())[0]);
    await until(async () => (await at("#slides .scrub").first().inputValue()).startsWith("7"));
    await at("#slides .name").first().press("Alt+ArrowDown");
    await until(async () => (await order())[1]);
    await until(() => page.evaluate(() => document.activeElement.dataset.key === "name1"));
    for (let n = 2; n >= 0; n--) {
      await at("#slides .remove").first().click();
      await until(async () => (await slides()).length === n);
    }
    assert.equal(await notice(), "");
  });

  step("play a folder with crossfades, pause it, and say which entry is shown", async () => {
    const list = () => quiltd.q.call("playlist.get");
    await tab("library");
    await at("#entries .path button, .path button").first().click();
    await at("#entries .whole").first().click();
    await until(async () => (await list()).playing);
    assert.ok((await list()).folder);
    await tab("slideshow");
    const panel = at("#panel-slideshow");
    await panel.getByRole("button", { name: "Pause" }).click();
    await until(async () => (await list()).paused);
    await until(async () => /Entry \d+ of \d+: .+, paused/.test(await panel.textContent()));
    const fade = panel.getByLabel("Seconds of a crossfade");
    await fade.fill("2");
    await fade.press("Enter");
    await until(async () => (await list()).crossfade === 2);
    await panel.getByRole("button", { name: "Go on" }).click();
    await until(async () => !(await list()).paused);
    await panel.getByRole("button", { name: "Stop" }).click();
    await until(async () => !(await list()).playing);
    assert.equal(await notice(), "");
  });
});

describe("every visitor", () => {
  const heights = { 360: 740, 1280: 800, 2560: 1440 };

  // What is wrong in the tabs of a page of this width.
  async function look(width, scheme) {
    const findingsHere = [];
    for (const name of tabs()) {
      await tab(name);
      await page.screenshot({ path: join(screenshots, `${width}-${scheme}-${name}.png`) });
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      if (wide > width) findingsHere.push(`${name} is ${wide} pixels wide`);
      for (const line of await findings(page)) findingsHere.push(`${name}: ${line}`);
    }
    return findingsHere;
  }

  before(async () => {
    if (failed) return;
    await mkdir(screenshots, { recursive: true });
    await quiltd.q.scene.load({ file: quiltd.scene });
    await settled();
    // the image stands still meanwhile
    await quiltd.q.render.set({ paused: true });
  });

  for (const scheme of ["light", "dark"])
    for (const width of [360, 1280])
      step(`has a page without serious faults at ${width} pixels, ${scheme}`, async () => {
        await page.setViewportSize({ width, height: heights[width] });
        await page.emulateMedia({ colorScheme: scheme });
        assert.deepEqual(await look(width, scheme), []);
      });

  step("keeps how far each tab is scrolled", async () => {
    const place = () => at("#panels").evaluate((one) => one.scrollTop);
    await page.setViewportSize({ width: 360, height: heights[360] });
    await tab("picture");
    await at("#panels").evaluate((one) => (one.scrollTop = 120));
    await tab("health");
    assert.equal(await place(), 0);
    await tab("picture");
    assert.equal(await place(), 120);
    await at("#panels").evaluate((one) => (one.scrollTop = 0));
  });

  step("can name a long file without a wider page", async () => {
    const name = `${"a_long_name_".repeat(8)}.glb`;
    await page.setViewportSize({ width: 360, height: heights[360] });
    await drop([{ name, data: makePyramid([0.2, 0.2, 0.7]) }]);
    await until(async () => (await at("#scene").textContent()).endsWith(name));
    await drop([{ name: name.replace("glb", "docx"), data: Buffer.from("text") }]);
    await until(async () => (await notice()).includes(".docx"));
    const right = await at("#dismiss").evaluate((one) => one.getBoundingClientRect().right);
    assert.ok(right <= 360, `the cross of the error ends at ${right}`);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 360);
    await at("#dismiss").click();
  });

  step("keeps a large part of a phone for the picture", async () => {
    await tab("picture");
    for (const [size, share] of [["half", 0.4], ["tall", 0.25]]) {
      await until(async () => {
        if ((await at("#side").getAttribute("data-size")) === size) return true;
        await at("#sheet").press("Enter");
      });
      const [stage, controls, side] = await Promise.all(["#stage", "#controls", "#side"].map((one) => at(one).boundingBox()));
      assert.ok(stage.height >= share * heights[360] - 1, `${size}: ${stage.height}`);
      assert.ok(controls.y + controls.height <= side.y, `${size}: the sheet covers the controls`);
      assert.ok(side.y + side.height <= heights[360] + 1, `${size}: the sheet ends at ${side.y + side.height}`);
    }
    const fold = heights[360];
    for (const id of ["exposure", "focus", "depth"]) {
      const { y, height } = await at(`#${id}`).boundingBox();
      assert.ok(y + height <= fold, `${id} ends at ${y + height}`);
    }
  });

  step("has a page of 2560 pixels", async () => {
    await page.setViewportSize({ width: 2560, height: heights[2560] });
    for (const scheme of ["light", "dark"]) {
      await page.emulateMedia({ colorScheme: scheme });
      await page.screenshot({ path: join(screenshots, `2560-${scheme}.png`) });
    }
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 2560);
  });

  step("asks nobody but quiltweb, and finds nothing wrong in the console", () => {
    const { host } = new URL(quiltd.url);
    const others = watch.requests.filter((url) => new URL(url).host !== host && !url.startsWith("blob:"));
    assert.ok(watch.requests.length > 10);
    assert.deepEqual([others, watch.errors], [[], []]);
  });
});
