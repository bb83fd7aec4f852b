// Merge patches: the examples of RFC 7396, and inverses of patches.
import assert from "node:assert/strict";
import { test } from "node:test";
import { difference, inverse, merge, patchAt, same, valueAt } from "../../../web/page/patch.js";

const examples = [
  [{ a: "b" }, { a: "c" }, { a: "c" }],
  [{ a: "b" }, { b: "c" }, { a: "b", b: "c" }],
  [{ a: "b" }, { a: null }, {}],
  [{ a: "b", b: "c" }, { a: null }, { b: "c" }],
  [{ a: ["b"] }, { a: "c" }, { a: "c" }],
  [{ a: "c" }, { a: ["b"] }, { a: ["b"] }],
  [{ a: { b: "c" } }, { a: { b: "d", c: null } }, { a: { b: "d" } }],
  [{ a: [{ b: "c" }] }, { a: [1] }, { a: [1] }],
  [{ e: null }, { a: 1 }, { e: null, a: 1 }],
  [[1, 2], { a: "b", c: null }, { a: "b" }],
  [{}, { a: { bb: { ccc: null } } }, { a: { bb: {} } }],
];

test("patches merge as in RFC 7396", () => {
  for (const [document, patch, result] of examples)
    assert.deepEqual(merge(document, patch), result);
});

const lights = () => ({
  lights: { sun: { type: "distant", direction: [0, -1, 0], angle: 0.5 }, sky: { type: "sky" } },
  backdrop: 1,
});
const patches = [
  { lights: { sun: { angle: 2 } } }, // a value
  { lights: { sun: { direction: [1, 0, 0] } } }, // an array is replaced
  { lights: { sun: null } }, // a removed object comes back whole
  { lights: { sun: { angle: null, irradiance: 3 } } }, // a removed and a new key
  { lights: { lamp: { type: "point", position: [0, 1, 0] } } }, // a new object
  { lights: null, film: { exposure: 1 } },
  { backdrop: { top: 1, bottom: 0 } }, // an object instead of a number
  { lights: 3 }, // a number instead of an object
  { lights: { sun: { missing: null } } }, // nothing
];

test("the inverse of a patch brings the document back, and the patch again", () => {
  for (const patch of patches) {
    const document = lights(),
      after = merge(document, patch);
    const undo = inverse(document, patch);
    assert.deepEqual(merge(after, undo), document);
    assert.deepEqual(merge(merge(after, undo), patch), after);
  }
});

test("steps are undone in order, also when each removes what the other made", () => {
  let document = lights();
  const undo = [];
  for (const patch of [...patches, ...patches]) {
    undo.unshift(inverse(document, patch));
    document = merge(document, patch);
  }
  for (const patch of undo) document = merge(document, patch);
  assert.deepEqual(document, lights());
});

test("a document is not changed by a patch", () => {
  const document = lights();
  merge(document, patches[0]);
  inverse(document, patches[0]);
  assert.deepEqual(document, lights());
});

test("a difference makes one document of another", () => {
  const from = { a: 1, b: { c: [1, 2], d: 2 }, e: {} },
    to = { b: { c: [1, 3], f: {} }, e: {}, g: { h: 1 } };
  assert.deepEqual(difference(from, to), {
    a: null,
    b: { d: null, c: [1, 3], f: {} },
    g: { h: 1 },
  });
  assert.deepEqual(merge(from, difference(from, to)), to);
  assert.deepEqual(difference(from, from), {});
});

test("names from outside are only names", () => {
  const patch = JSON.parse('{"__proto__": {"polluted": 1}, "constructor": 2}');
  const result = merge({}, patch);
  assert.equal({}.polluted, undefined);
  assert.deepEqual(Object.keys(result), ["__proto__", "constructor"]);
  assert.deepEqual(merge(result, inverse({}, patch)), {});
});

test("values are found and set by a path", () => {
  assert.deepEqual(patchAt(["a", "b"], 3), { a: { b: 3 } });
  assert.equal(valueAt({ a: { b: 3 } }, ["a", "b"]), 3);
  assert.equal(valueAt({ a: 1 }, ["a", "b", "c"]), undefined);
  assert.equal(valueAt({}, ["toString"]), undefined);
});

test("equal values are the same", () => {
  assert.ok(same({ a: [1, { b: null }] }, { a: [1, { b: null }] }));
  assert.ok(!same({ a: 1 }, { b: 1 }));
  assert.ok(!same([1], [1, 2]));
  assert.ok(!same({}, []));
  assert.ok(!same(null, {}));
});
