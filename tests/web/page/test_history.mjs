// What can be undone and redone.
import assert from "node:assert/strict";
import { test } from "node:test";
import { History } from "../../../web/page/history.js";

const step = (n, group) => ({ undo: { a: n - 1 }, redo: { a: n }, group });

test("steps come back in order, and can be done again", () => {
  const history = new History();
  history.push(step(1));
  history.push(step(2));
  assert.deepEqual(
    [history.undo(), history.undo(), history.undo()],
    [{ a: 1 }, { a: 0 }, undefined],
  );
  assert.deepEqual(
    [history.redo(), history.redo(), history.redo()],
    [{ a: 1 }, { a: 2 }, undefined],
  );
  assert.ok(history.canUndo && !history.canRedo);
});

test("a gesture is one step, from its beginning to its end", () => {
  const history = new History();
  for (let n = 1; n <= 5; n++) history.push(step(n, "drag"));
  history.push(step(6, "other"));
  assert.deepEqual(
    [history.undo(), history.undo(), history.undo()],
    [{ a: 5 }, { a: 0 }, undefined],
  );
  assert.deepEqual(history.redo(), { a: 5 });
});

test("steps without a group are never joined", () => {
  const history = new History();
  history.push(step(1));
  history.push(step(2));
  assert.deepEqual(history.undo(), { a: 1 });
});

test("a new step ends what could be redone", () => {
  const history = new History();
  history.push(step(1));
  history.undo();
  history.push(step(9));
  assert.equal(history.redo(), undefined);
});

test("a refused step is forgotten, another is not", () => {
  const history = new History();
  history.push(step(1, "a"));
  history.push(step(2, "b"));
  history.drop("a");
  history.drop(undefined);
  history.drop("b");
  assert.deepEqual(history.undo(), { a: 0 });
});

test("a step without a group is never dropped", () => {
  const history = new History();
  history.push(step(1));
  history.drop(undefined);
  assert.ok(history.canUndo);
});

test("a reload keeps the steps, and a gesture after it is a new one", () => {
  const history = new History(),
    restored = new History();
  history.push(step(1, "drag"));
  history.push(step(2));
  history.undo();
  restored.restore(history.save());
  assert.deepEqual(restored.redo(), { a: 2 });
  restored.undo();
  restored.push(step(3, "drag"));
  assert.deepEqual([restored.undo(), restored.undo()], [{ a: 2 }, { a: 0 }]);
});

test("the memory is bounded: the oldest steps go first", () => {
  const history = new History();
  for (let n = 1; n <= 500; n++) history.push(step(n));
  let undone = 0;
  while (history.undo()) undone++;
  assert.equal(undone, 100);
  const long = new History();
  for (let n = 0; n < 20; n++) long.push({ undo: { n }, redo: { text: "x".repeat(200000) } });
  const text = long.save(),
    kept = new History();
  assert.ok(text.length <= 1 << 20);
  kept.restore(text);
  assert.deepEqual(kept.undo(), { n: 19 });
});
