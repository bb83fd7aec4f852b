// Colours between linear light and the codes of a colour field.
import assert from "node:assert/strict";
import { test } from "node:test";
import { hexOf, linearOf, splitColour, withStrength } from "../../../web/page/colour.js";

test("codes of sRGB", () => {
  assert.equal(hexOf([0, 0.5, 1]), "#00bcff");
  assert.equal(hexOf([0.002, 0.0031308, 0.18]), "#070a76");
  assert.equal(hexOf([-1, 2, 1]), "#00ffff");
});

test("each code comes back", () => {
  for (let code = 0; code < 256; code++) {
    const hex = `#${code.toString(16).padStart(2, "0").repeat(3)}`;
    assert.equal(hexOf(linearOf(hex)), hex);
  }
});

test("light brighter than 1 is a hue and a strength", () => {
  assert.deepEqual(splitColour([4, 2, 0]), { strength: 4, hex: "#ffbc00" });
  assert.deepEqual(splitColour(3), { strength: 3, hex: "#ffffff" });
  assert.deepEqual(splitColour([0, 0, 0]), { strength: 0, hex: "#ffffff" });
});

test("another strength keeps the hue", () => {
  assert.deepEqual(withStrength([4, 2, 0], 2), [2, 1, 0]);
  assert.deepEqual(withStrength([0, 0, 0], 2), [2, 2, 2]);
  assert.equal(withStrength(3, 5), 5);
});
