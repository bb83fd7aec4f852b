// The time left.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Remaining } from "../../../web/page/remaining.js";

const status = (seconds, seconds_left, more) => ({
  state: "rendering",
  generation: 1,
  target_error: 1e-4,
  passes: 20,
  seconds,
  seconds_left,
  ...more,
});
// The words after each of these estimates.
const after = (lefts, more) => {
  const remaining = new Remaining();
  return lefts.map((left, i) => remaining.take(status(10 + i, left, more)));
};

test("it is told when six estimates agree", () => {
  const words = after([610, 640, 600, 620, 590, 605, 600]);
  assert.deepEqual(words, ["", "", "", "", "", "about 10 min left", "about 10 min left"]);
});

test("estimates that jump say nothing", () => {
  const hour = 3600;
  assert.ok(after([8, 13, 6, 16, 8, 13, 6].map((n) => n * hour)).every((words) => words === ""));
});

test("nothing is told before 8 passes, and without an estimate", () => {
  assert.ok(after(Array(9).fill(600), { passes: 7.9 }).every((words) => words === ""));
  assert.ok(after(Array(9).fill(null)).every((words) => words === ""));
});

test("another image, or another target, begins anew", () => {
  for (const more of [{ generation: 2 }, { target_error: 1e-3 }]) {
    const remaining = new Remaining();
    for (let i = 0; i < 8; i++) remaining.take(status(10 + i, 600));
    assert.equal(remaining.take(status(20, 600)), "about 10 min left");
    assert.equal(remaining.take(status(21, 600, more)), "");
  }
});

test("what is not rendered has no time left", () => {
  const remaining = new Remaining();
  assert.equal(remaining.take({ state: "paused" }), "paused");
  assert.match(remaining.take({ state: "converged" }), /^done/);
  assert.equal(remaining.take({ state: "idle" }), "");
});
