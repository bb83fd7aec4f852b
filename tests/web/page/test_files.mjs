// What files are by their names.
import assert from "node:assert/strict";
import { test } from "node:test";
import { environmentPatch, kindOf, mainOf, mayName, notesOn, safePath, saysAll, tilesOf } from "../../../web/page/files.js";
import { merge } from "../../../web/page/patch.js";

test("names have kinds", () => {
  const kinds = {
    "a.GLB": "model",
    "b.vdb": "volume",
    "c.hdr": "environment",
    "d.exr": "environment",
    "e.json": "scene",
    "f.jpg": "image",
    "g_qs8x6a0.75.png": "quilt",
    "h_qs5x9.jpg": "quilt",
    "i.bin": undefined,
    "j_qs8x6.json": "scene",
    k: undefined,
  };
  for (const [name, kind] of Object.entries(kinds)) assert.equal(kindOf(name), kind, name);
});

test("the main file of a drop is the one that names the others", () => {
  assert.equal(mainOf(["a/b.png", "a/model.gltf", "a/model.bin"]), "a/model.gltf");
  assert.equal(mainOf(["x.glb", "scene.json"]), "scene.json");
  assert.equal(mainOf(["sky.hdr"]), "sky.hdr");
  assert.equal(mainOf(["notes.txt"]), undefined);
});

test("tiles are columns x rows", () => {
  assert.equal(tilesOf("8x6"), "8x6");
  assert.equal(tilesOf(" 8 x 6 "), "8x6");
  assert.equal(tilesOf("8×6"), "8x6");
  for (const text of ["", "8", "0x6", "8x", "axb", "8x6x4"])
    assert.equal(tilesOf(text), undefined, text);
});

test("paths stay below their folder", () => {
  assert.equal(safePath("/a/../../b/./c.png"), "a/b/c.png");
});

test("a picture of light takes the place of the other light at infinity", () => {
  const scene = {
    lights: {
      day: { type: "sky", elevation: 3 },
      lamp: { type: "point" },
      old: { type: "environment", radiance: 1, rotate: 20 },
    },
    backdrop: [0, 0, 0],
  };
  assert.deepEqual(merge(scene, environmentPatch(scene, "/upload/1/a.hdr")), {
    lights: {
      lamp: { type: "point" },
      old: { type: "environment", file: "/upload/1/a.hdr", rotate: 20 },
    },
  });
  assert.deepEqual(environmentPatch({}, "/a.exr"), {
    lights: { environment: { type: "environment", file: "/a.exr" } },
  });
});

test("of several models only one is shown, and its name is told", () => {
  assert.deepEqual(notesOn(["a.glb", "b.obj", "c.vdb"], "a.glb", [""]), [
    "Of 3 files only a.glb is shown.",
  ]);
  assert.deepEqual(notesOn(["a.png", "b.jpg"], "a.png", []), ["Of 2 files only a.png is shown."]);
  assert.deepEqual(notesOn(["a.glb"], "a.glb", undefined), []);
});

test("a texture that no model names is told; one that is named is not", () => {
  const names = ["a.obj", "a.mtl", "maps/My Wood.PNG", "stone.jpg"];
  const texts = ["mtllib a.mtl", "map_kd my wood.png"];
  assert.deepEqual(notesOn(names, "a.obj", texts), ["stone.jpg is not used: no other file names it."]);
  assert.deepEqual(notesOn(["a.gltf", "my wood.png"], "a.gltf", ['"my%20wood.png"']), []);
  assert.deepEqual(notesOn(names, "a.obj", undefined), []);
  assert.ok(mayName("A.MTL") && !mayName("a.png"));
});

test("a name says tiles or depth, or nothing", () => {
  for (const name of ["a_qs8x6a0.75.png", "a_rgbd.png", "A_RGBD.MP4", "t_qs3x2.mp4"])
    assert.ok(saysAll(name), name);
  for (const name of ["a.png", "a_rgbd.png.jpg", "rgbd.png", "turn.mp4", "a_rgbd2.png"])
    assert.ok(!saysAll(name), name);
});
