// Values that a person has set, until the daemon has them.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Held } from "../../../web/page/held.js";

test("without a change, the status is shown", () => {
  assert.equal(new Held().show("exposure", 2), 2);
});

test("an older status does not move a control, before and after the answer", () => {
  const held = new Held();
  held.set("exposure", 1);
  for (let i = 0; i < 20; i++) assert.equal(held.show("exposure", 4.875), 1);
  held.answered({ exposure: 1 });
  assert.deepEqual([held.show("exposure", 4.875), held.show("exposure", 2.875)], [1, 1]);
  assert.equal(held.show("exposure", 1), 1);
  assert.equal(held.show("exposure", 3), 3);
  assert.equal(held.show("denoise", "on"), "on");
});

test("the answer to an earlier value frees nothing", () => {
  const held = new Held();
  held.set("exposure", 1);
  held.set("exposure", 2);
  held.answered({ exposure: 1 });
  held.refused({ exposure: 1 });
  for (let i = 0; i < 20; i++) assert.equal(held.show("exposure", 1), 2);
});

test("a refused value is not shown any more", () => {
  const held = new Held();
  held.set("exposure", 99);
  held.refused({ exposure: 99 });
  assert.equal(held.show("exposure", 1), 1);
});

test("what another client sets is shown after some statuses", () => {
  const held = new Held();
  held.set("exposure", 1);
  held.answered({ exposure: 1 });
  const shown = Array.from({ length: 7 }, () => held.show("exposure", 3));
  assert.deepEqual(shown, [1, 1, 1, 1, 1, 3, 3]);
});
