// The fields of the scene's tree, by the schema that quiltweb serves.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";
import * as schemas from "../../../web/page/schema.js";

const root = JSON.parse(readFileSync(new URL("../../../docs/scene.schema.json", import.meta.url)));
const of = (name) => ({ $ref: `#/$defs/${name}` });
const property = (name, key) => schemas.pick(root, of(name), {}).properties[key];

test("a value has the field of its kind", () => {
  const camera = schemas.resolve(root, of("camera")).properties;
  assert.equal(schemas.fieldOf(root, camera.fov_y, 14), "number");
  assert.equal(schemas.fieldOf(root, camera.fov_y, { keys: [[1, 2]] }), "object");
  assert.equal(schemas.fieldOf(root, camera.position, [0, 0, 5]), "vector");
  assert.equal(schemas.fieldOf(root, camera.placement, "centred"), "choice");
  assert.equal(schemas.fieldOf(root, camera.fit, true), "switch");
  assert.equal(schemas.fieldOf(root, camera.fit, "knot"), "text");
  assert.equal(schemas.fieldOf(root, camera.views, 45), "number");
  assert.equal(schemas.fieldOf(root, camera.views, { circle: {} }), "object");
  assert.equal(schemas.fieldOf(root, property("material", "albedo"), [0.1, 0.2, 0.3]), "colour");
  assert.equal(schemas.fieldOf(root, property("material", "albedo"), 0.5), "colour");
  assert.equal(schemas.fieldOf(root, of("keyed"), { keys: [[1, 2]] }), "object");
  assert.equal(schemas.fieldOf(root, property("volume", "grid"), ["a", "b"]), "json");
  assert.equal(schemas.fieldOf(root, { enum: ["a", "b"] }, 3), "number"); // of no known kind
});

test("ranges and words come from the schema", () => {
  const { fov_y, views } = schemas.resolve(root, of("camera")).properties;
  assert.deepEqual(schemas.rangeOf(root, fov_y), {
    minimum: 0.1,
    maximum: 160,
    integer: false,
    unit: "degrees",
  });
  assert.equal(schemas.rangeOf(root, views).integer, true);
  assert.equal(schemas.rangeOf(root, of("radiance")).maximum, 1e9);
  assert.match(
    schemas.describe(root, fov_y),
    /^vertical angle of the window.*0\.1 to 160; degrees; usually 14$/,
  );
});

test("the alternative is that of the value", () => {
  const kind = (value) => schemas.pick(root, of("light"), value).properties;
  assert.equal(kind({ type: "sphere", power: 3 }).power !== undefined, true);
  assert.equal(kind({ type: "sphere", radiance: 3 }).power, undefined);
  assert.equal(kind({ type: "environment", file: "a.hdr" }).rotate !== undefined, true);
  assert.equal(kind({ type: "sky" }).turbidity !== undefined, true);
  // one that fits none is shown by the keys that it has
  assert.equal(kind({ type: "spot", blend: 7 }).blend !== undefined, true);
});

test("an object can become another kind, and keeps what that kind has", () => {
  const sphere = { type: "sphere", position: [0, 1, 0], radius: 2, radiance: 3 };
  assert.deepEqual(schemas.choicesOf(root, of("light"), "type"), [
    "environment",
    "sky",
    "studio",
    "distant",
    "point",
    "spot",
    "rectangle",
    "disk",
    "sphere",
  ]);
  assert.deepEqual(schemas.retyped(root, of("light"), sphere, "type", "disk"), {
    type: "disk",
    radiance: 3,
    position: [0, 1, 0],
    radius: 2,
  });
  assert.deepEqual(schemas.retyped(root, of("light"), sphere, "type", "point"), {
    type: "point",
    position: [0, 1, 0],
  });
  assert.deepEqual(schemas.retyped(root, of("light"), { type: "sky" }, "type", "environment"), {
    type: "environment",
    radiance: 1,
  });
  assert.equal(schemas.retyped(root, of("light"), sphere, "type", "laser"), undefined);
});

test("a kind that shares its keys with another can be chosen, too", () => {
  const clay = { type: "diffuse", albedo: [0.1, 0.2, 0.3] };
  assert.deepEqual(schemas.retyped(root, of("material"), clay, "type", "plastic"), {
    ...clay,
    type: "plastic",
  });
});

test("samples are valid; a file is for a person to choose", () => {
  assert.equal(schemas.sample(root, property("mesh", "file")), undefined);
  assert.equal(schemas.sample(root, of("picture")), undefined);
  for (const name of ["camera", "light", "material", "volume", "mesh"])
    for (const one of schemas.variants(root, of(name)))
      for (const [key, schema] of schemas.propertiesOf(one)) {
        const value = schemas.sample(root, schema);
        if (value !== undefined)
          assert.ok(schemas.fits(root, schema, value), `${name}.${key}: ${JSON.stringify(value)}`);
      }
});

test("former names are not offered", () => {
  const keys = schemas.propertiesOf(root).map(([key]) => key);
  assert.ok(keys.includes("fps") && !keys.includes("rate"));
});

test("wrong values do not fit", () => {
  const { fov_y, position } = schemas.resolve(root, of("camera")).properties;
  for (const value of [0, 161, "14", null, true, [14]])
    assert.ok(!schemas.fits(root, fov_y, value), String(value));
  for (const value of [
    [0, 0],
    [0, 0, 0, 0],
    [0, 0, "0"],
    [0, 0, 1e10],
  ])
    assert.ok(!schemas.fits(root, position, value));
  for (const light of [{ type: "sky", unknown: 1 }, { type: "sphere" }, {}, 3])
    assert.ok(!schemas.fits(root, of("light"), light));
});
