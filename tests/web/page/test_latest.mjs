// One call at a time.
import assert from "node:assert/strict";
import { test } from "node:test";
import { latest } from "../../../web/page/latest.js";

test("what is asked for during a call is merged, and the last value wins", async () => {
  const calls = [];
  let release;
  const send = latest((params) => {
    calls.push(params);
    return new Promise((resolve) => (release = resolve));
  });
  const end = send({ a: 1 });
  send({ a: 2 });
  send({ a: 2, b: 1 });
  send({ a: 3 });
  assert.deepEqual(calls, [{ a: 1 }]);
  release();
  await new Promise(setImmediate);
  assert.deepEqual(calls, [{ a: 1 }, { a: 3, b: 1 }]);
  release();
  await end;
  send({ a: 4 });
  assert.equal(calls.length, 3);
});
