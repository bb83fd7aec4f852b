// Two views for two eyes.
import assert from "node:assert/strict";
import { test } from "node:test";
import { anaglyph, pairAt, RED_OF_LEFT, viewAt, viewsApart } from "../../../web/page/stereo.js";

test("the eyes are about 6 degrees apart, or as many views as chosen", () => {
  assert.equal(viewsApart("eyes", 45, 40), 7); // 6.2 degrees
  assert.equal(viewsApart("eyes", 48, 35), 8);
  assert.equal(viewsApart("eyes", 9, 40), 1);
  assert.equal(viewsApart("eyes", 1, 40), 0);
  assert.equal(viewsApart("4", 45, 40), 4);
  assert.equal(viewsApart("8", 3, 40), 2);
});

test("a pair is around the position, with the left eye further left", () => {
  assert.deepEqual(pairAt(0.5, 45, 4), [20, 24]);
  assert.deepEqual(pairAt(0, 45, 4), [0, 4]);
  assert.deepEqual(pairAt(1, 45, 4), [40, 44]);
  assert.deepEqual(pairAt(0.7, 1, 0), [0, 0]);
  assert.deepEqual(pairAt(0.7, 0, 0), [0, 0]);
});

test("each view has an equal share of the slider", () => {
  assert.equal(viewAt(0, 9), 0);
  assert.equal(viewAt(0.5, 9), 4);
  assert.equal(viewAt(1, 9), 8);
});

test("red and cyan keep grey neutral", () => {
  assert.ok(Math.abs(RED_OF_LEFT.reduce((a, b) => a + b) - 1) < 1e-12);
  for (const grey of [0, 0.25, 1])
    for (const channel of anaglyph([grey, grey, grey], [grey, grey, grey]))
      assert.ok(Math.abs(channel - grey) < 1e-12);
});

test("red comes from the left eye alone, the others from the right one", () => {
  assert.deepEqual(anaglyph([0, 0, 0], [1, 0.5, 0.25]), [0, 0.5, 0.25]);
  assert.deepEqual(anaglyph([0, 1, 0], [0, 0, 0]), [RED_OF_LEFT[1], 0, 0]);
});
