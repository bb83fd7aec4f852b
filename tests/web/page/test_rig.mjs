// The camera: what the focal plane and the target do.
import assert from "node:assert/strict";
import { test } from "node:test";
import { distanceOf, placed, shifted, targetAt } from "../../../web/page/rig.js";

const close = (a, b) =>
  a.forEach((x, i) => assert.ok(Math.abs(x - b[i]) < 1e-9, `${a} is not ${b}`));

test("keys that are left out have the usual values", () => {
  assert.deepEqual(placed(undefined).position, [0, 0, 5]);
  assert.equal(placed({ position: { keys: [[1, [0, 0, 1]]] } }), undefined);
  assert.equal(placed({ from: { mesh: "room" } }), undefined);
});

test("the focal plane moves along the line of sight, and the camera stays", () => {
  const camera = placed({ position: [0, 1.7, 12.1], target: [0, 0, 0] });
  const target = targetAt(camera, 20);
  assert.ok(Math.abs(distanceOf({ position: camera.position, target }) - 20) < 1e-9);
  // the three points are on one line, the target before the position
  const scale = 20 / distanceOf(camera);
  close(target, [0, 1.7 - 1.7 * scale, 12.1 - 12.1 * scale]);
});

test("the target follows the image: a drag over the whole height is the height of the window", () => {
  const camera = placed({ position: [0, 0, 10], target: [0, 0, 0], fov_y: 90 });
  const { position, target } = shifted(camera, 0, 500, 500);
  close(target, [0, 20, 0]);
  close(position, [0, 20, 10]);
  close(shifted(camera, 250, 0, 500).target, [-10, 0, 0]);
});
