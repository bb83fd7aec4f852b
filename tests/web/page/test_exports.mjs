// The form of exports.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  EXPORTS,
  jobText,
  kindsOf,
  LABELS,
  nameFor,
  parametersOf,
  valueOf,
} from "../../../web/page/exports.js";

const parameters = {
  kind: { enum: ["quilt", "still", "print"] },
  lpi: { type: "number" },
  width: { type: "number" },
  height: { type: "number" },
  dpi: { type: ["string", "number"] },
  denoise: { enum: ["auto", "on"] },
};

test("only what quiltd knows is offered", () => {
  assert.deepEqual(kindsOf(parameters), ["still", "quilt", "print"]);
  assert.deepEqual(kindsOf(undefined), []);
  assert.deepEqual(
    parametersOf("still", parameters).map(([key]) => key),
    ["denoise"],
  );
  assert.deepEqual(
    parametersOf("print", parameters).map(([key, , needed]) => [key, needed]),
    [
      ["lpi", true],
      ["width", true],
      ["height", true],
      ["dpi", false],
    ],
  );
});

test("the file is named after the scene and what it is; a quilt by its tiles", () => {
  const status = { scene: "/srv/scenes/first light.json", columns: 8, rows: 6, aspect: 0.75 };
  assert.equal(nameFor("still", status, "png"), "first_light.png");
  assert.equal(nameFor("panel", status, "png"), "first_light_panel.png");
  assert.equal(nameFor("quilt", status, "jpg"), "first_light_qs8x6a0.75.jpg");
  assert.equal(
    nameFor("quilt", { ...status, scene: "/a/cat_qs5x9a0.5.png" }, "png"),
    "cat_qs8x6a0.75.png",
  );
  assert.equal(nameFor("still", { scene: null }, "png"), "image.png");
});

test("texts become values", () => {
  assert.equal(valueOf({ type: "number" }, " 60,5 "), 60.5);
  assert.equal(valueOf({ type: ["string", "number"] }, "600x300"), "600x300");
  assert.equal(valueOf({ type: "string" }, "60"), "60");
  assert.equal(valueOf({ type: "number" }, " "), undefined);
  assert.equal(valueOf({ type: "boolean", default: false }, false), undefined);
  assert.equal(valueOf({ type: "boolean", default: false }, true), true);
});

test("every parameter has a label, without its unit", () => {
  for (const { needed = [], keys } of Object.values(EXPORTS))
    for (const key of [...needed, ...keys]) {
      assert.match(LABELS[key], /^[A-Z]/, key);
      assert.doesNotMatch(LABELS[key], /lpi|dpi|mm|kelvin/);
    }
});

test("fields of photos are there for photos alone", () => {
  const known = { ...parameters, photo: { enum: ["fit", "fill"] } };
  const keys = (photo) => parametersOf("print", known, photo).map(([key]) => key);
  assert.equal(keys(false).includes("photo"), false);
  assert.equal(keys(true).includes("photo"), true);
});

test("a job on a farm tells its tasks", () => {
  const farm = { engine: "slurm", state: "queued", tasks: { complete: 3, total: 12 } };
  assert.equal(jobText("running", undefined, farm), "slurm: queued, 3 of 12 tasks");
  assert.equal(
    jobText("running", undefined, { ...farm, state: "planning", tasks: { complete: 0, total: 0 } }),
    "slurm: planning",
  );
  assert.equal(jobText("done", undefined, farm), "done");
  assert.equal(jobText("failed", { message: "no memory" }, farm), "no memory");
  assert.equal(jobText("running"), "running");
});
