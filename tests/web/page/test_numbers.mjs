// Numbers that are typed and dragged.
import assert from "node:assert/strict";
import { test } from "node:test";
import { dragged, format, limit, nudged, parse, stepOf, tidy } from "../../../web/page/numbers.js";

test("numbers are short", () => {
  assert.equal(format(0.1 + 0.2), "0.3");
  assert.equal(format(12.1), "12.1");
  assert.equal(format(undefined), "");
  assert.equal(tidy(1 / 3, 2), 0.33);
});

test("typed numbers may have a comma; other text is none", () => {
  assert.equal(parse(" 1,5 "), 1.5);
  assert.equal(parse("-2e3"), -2000);
  for (const text of ["", " ", "a", "1 2", "1e999", "NaN"]) assert.equal(parse(text), undefined);
});

test("values stay in their range", () => {
  assert.equal(limit(7, { minimum: 0, maximum: 1 }), 1);
  assert.equal(limit(-7, { minimum: 0 }), 0);
  assert.equal(limit(2.6, { integer: true }), 3);
  assert.equal(limit(7, {}), 7);
});

test("steps follow the range, or the size of the value", () => {
  assert.equal(stepOf(0.5, { minimum: 0, maximum: 1 }), 0.001);
  assert.equal(stepOf(3, { minimum: -3600, maximum: 3600, unit: "degrees" }), 0.5);
  assert.equal(stepOf(30, { minimum: 0, maximum: 1e9 }), 0.1);
  assert.equal(stepOf(0, {}), 0.01);
});

test("a drag adds its pixels, in whole steps, and stops at the ends", () => {
  assert.equal(dragged(0.2, 100, { minimum: 0, maximum: 1 }), 0.3);
  assert.equal(dragged(0.2, 10000, { minimum: 0, maximum: 1 }), 1);
  assert.equal(dragged(45, 30, { integer: true, minimum: 1, maximum: 256 }), 48);
  assert.equal(dragged(12.34, -10, { minimum: -1e9, maximum: 1e9 }), 11.3);
});

test("an arrow key adds one, a degree or ten steps", () => {
  assert.equal(nudged(45, -1, { integer: true }), 44);
  assert.equal(nudged(20, 1, { minimum: 0.1, maximum: 160, unit: "degrees" }), 21);
  assert.equal(nudged(0.25, 2, { minimum: 0, maximum: 1 }), 0.27);
  assert.equal(nudged(0.995, 1, { minimum: 0, maximum: 1 }), 1);
});
