// The settings of rendering, and their undo.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Render } from "../../../web/page/render.js";
import { Scene } from "../../../web/page/scene.js";

// A daemon that answers at once.
class FakeRpc extends EventTarget {
  calls = [];
  async call(method, params) {
    this.calls.push([method, params]);
    return {};
  }
}

function begin() {
  const rpc = new FakeRpc();
  const scene = new Scene(rpc, () => {});
  return { rpc, scene, render: new Render(rpc, scene, () => {}) };
}
const status = (stops, more) => ({ exposure: { stops, auto: false }, denoise: "on", ...more });
const turn = () => new Promise((resolve) => setTimeout(resolve));

test("a drag of the exposure is one step of undo and of redo", async () => {
  const { rpc, scene, render } = begin();
  render.follow(status(3));
  for (const exposure of [2, 1.5, 1]) render.set({ exposure }, "drag");
  assert.equal(render.follow(status(3)).exposure, 1);
  await scene.undo();
  await turn();
  assert.deepEqual(rpc.calls.at(-1), ["render.set", { exposure: 3 }]);
  assert.equal(scene.canUndo, false);
  scene.redo();
  await turn();
  assert.deepEqual(rpc.calls.at(-1), ["render.set", { exposure: 1 }]);
});

test("an exposure of the scene, or an automatic one, is that again", async () => {
  const { rpc, scene, render } = begin();
  for (const [exposure, before] of [
    [{ stops: 0, auto: false }, "scene"],
    [{ stops: 4, auto: true }, "auto"],
  ]) {
    render.follow({ exposure });
    render.set({ exposure: 2 }, `drag to ${before}`);
    await scene.undo();
    await turn();
    assert.deepEqual(rpc.calls.at(-1), ["render.set", { exposure: before }]);
    assert.equal(render.follow({ exposure: { stops: 9, auto: false } }).exposure, before === "auto" ? before : 0);
    render.follow({ exposure: { stops: 0, auto: before === "auto" } }); // it is what is shown now
  }
});

test("a pause is no step", () => {
  const { scene, render } = begin();
  render.follow(status(0, { paused: false }));
  render.set({ paused: true });
  assert.equal(scene.canUndo, false);
  render.set({ denoise: "off" });
  assert.equal(scene.canUndo, true);
});
