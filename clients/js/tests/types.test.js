// The types of methods are those of quiltd.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { after, before, describe, it } from "node:test";

import { types } from "../make_types.js";
import { start } from "./live.js";

let live;
before(async () => (live = await start()));
after(() => live.stop());

describe("methods.d.ts", () => {
  it("follows from hello (make docs)", async () => {
    const written = await readFile(new URL("../quiltd/methods.d.ts", import.meta.url), "utf8");
    assert.ok(written === types(live.q.info), "quiltd/methods.d.ts is not up to date; run make docs");
  });
});

describe("the package", () => {
  it("has the version of quiltd", async () => {
    const { version } = JSON.parse(await readFile(new URL("../package.json", import.meta.url), "utf8"));
    assert.equal(version, live.q.info.version);
  });
});
