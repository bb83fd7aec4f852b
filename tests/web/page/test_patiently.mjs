// Requests that are repeated.
import assert from "node:assert/strict";
import { test } from "node:test";
import { patiently } from "../../../web/page/patiently.js";

// What is asked and waited for, if the answers have these statuses.
async function ask(...statuses) {
  const waits = [];
  let asked = 0;
  const answer = async () => {
    const status = statuses[Math.min(asked++, statuses.length - 1)];
    return { status, ok: status === 200, blob: async () => "image" };
  };
  const blob = await patiently(answer, async (ms) => waits.push(ms));
  return { blob, asked, waits };
}

test("an answer needs no second request", async () => {
  assert.deepEqual(await ask(200), { blob: "image", asked: 1, waits: [] });
});

test("503 is asked again, after growing waits", async () => {
  const { blob, asked, waits } = await ask(503, 503, 200);
  assert.deepEqual([blob, asked], ["image", 3]);
  assert.ok(waits.length === 2 && waits[1] > waits[0]);
});

test("it ends: after five times 503, and at once if refused otherwise", async () => {
  assert.deepEqual((({ blob, asked }) => [blob, asked])(await ask(503)), [undefined, 5]);
  assert.deepEqual((({ blob, asked }) => [blob, asked])(await ask(422)), [undefined, 1]);
});
