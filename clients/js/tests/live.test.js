// The client with a real quiltd, over its socket and over a quiltweb.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { readFile, readdir } from "node:fs/promises";
import { connect as connectTcp, createServer as createPlainServer } from "node:net";
import { join } from "node:path";
import { after, before, describe, it } from "node:test";
import { createServer } from "node:tls";
import { fileURLToPath } from "node:url";
import { promisify } from "node:util";

import { connect } from "../quiltd/node.js";
import { HEIGHT, VIEWS, WIDTH, freePort, start, startGateway } from "./live.js";

const examples = fileURLToPath(new URL("../examples/", import.meta.url));
let live;
before(async () => (live = await start()));
after(() => live.stop());

const doors = { socket: () => live.socket, gateway: () => live.url };
for (const [door, where] of Object.entries(doors))
  describe(`over the ${door}`, () => {
    let q;
    before(async () => (q = await connect(where())));
    after(() => q.close());

    it("has each method of hello as a member", () => {
      for (const name of Object.keys(q.info.methods))
        assert.equal(typeof name.split(".").reduce((at, word) => at[word], q), "function", name);
    });

    it("turns the camera and waits for the image", async () => {
      const { generation: first } = await q.status();
      const { generation } = await q.camera.orbit({ yaw: 15 });
      assert.ok(generation > first);
      const shown = await q.wait("complete", { timeout: 120 });
      assert.equal(shown.generation, generation);
    });

    it("tells an error by its name, code and place", async () => {
      await assert.rejects(q.camera.set({ fov: 20 }), { name: "ParameterError", code: -32602, message: /fov_y/ });
      await assert.rejects(q.scene.patch({ patch: { lights: { sky: { radianc: 1 } } } }), (error) => {
        assert.deepEqual([error.name, error.data.pointer], ["BadScene", "/lights/sky/radianc"]);
        return true;
      });
      await assert.rejects(q.call("scene.lead"), { name: "MethodNotFound", code: -32601 });
      await q.render.set({ target_error: 1e-12 });
      await assert.rejects(q.wait("converged", { timeout: 0.05 }), { name: "TimedOut", code: -32004 });
      await assert.rejects(q.call("wait", { for: "converged" }, { timeout: 0.05 }), { name: "TimedOut", code: undefined });
    });

    it("yields notifications of the events that were asked for", async () => {
      const events = q.events("frame", "scene");
      const { generation } = await q.camera.orbit({ yaw: 1 });
      const names = new Set();
      for await (const { name, params } of events) {
        names.add(name);
        if (name === "frame" && params.generation >= generation) break;
      }
      assert.deepEqual([...names].sort(), ["frame", "scene"]);
      await q.camera.orbit({ yaw: 1 });
      await q.wait();
      assert.deepEqual(await events.next(), { value: undefined, done: true });
    });

    it("refuses unknown events, and ends without one", async () => {
      assert.throws(() => q.events("frames"), { name: "ParameterError", message: /frames.*quiltd has frame/ });
      const seen = [];
      for await (const event of q.events("button", { timeout: 0.05 })) seen.push(event);
      assert.deepEqual(seen, []);
    });

    it("has two readers of the same event", async () => {
      const [one, two] = [q.events("scene"), q.events("scene")];
      const { generation } = await q.camera.orbit({ pitch: 1 });
      for (const reader of [one, two]) assert.equal((await reader.next()).value.params.generation, generation);
      one.return();
      const { generation: later } = await q.camera.orbit({ pitch: -1 });
      assert.equal((await two.next()).value.params.generation, later);
      two.return();
    });
  });

describe("the gateway alone", () => {
  let q;
  before(async () => (q = await connect(live.url)));
  after(() => q.close());

  it("yields images, each of a later picture", async () => {
    const seen = [];
    for await (const image of q.images()) {
      assert.deepEqual([image.views, image.jpeg[0], image.jpeg[1]], [VIEWS, 0xff, 0xd8]);
      assert.deepEqual([image.width <= WIDTH, image.height <= HEIGHT], [true, true]);
      seen.push(image.generation);
      if (seen.length === 3) break;
      await q.camera.orbit({ yaw: 2 });
      await q.wait("complete", { timeout: 120 });
    }
    assert.deepEqual(seen, [...seen].sort((a, b) => a - b));
    assert.ok(seen[2] > seen[0]);
  });

  it("gives the image that is shown", async () => {
    const { generation } = await q.wait("complete", { timeout: 120 });
    const image = await q.preview();
    assert.deepEqual([image.generation, image.level !== "none"], [generation, true]);
  });

  it("has one reader of images at a time", async () => {
    const first = q.images();
    await first.next();
    await assert.rejects(q.images().next(), { name: "Busy" });
    await first.return();
    assert.ok(await q.preview());
  });

  it("shows what is uploaded, with the files that belong to it", async () => {
    const mesh = new TextEncoder().encode("mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const { path, folder } = await q.upload("a b.obj", mesh);
    const material = await q.upload("a.mtl", new Blob(["newmtl a\nKd 0.1 0.2 0.3\n"]), { folder });
    assert.deepEqual(await q.scene.load({ file: path, files: [path, material.path] }).then(({ warnings }) => warnings), []);
    assert.equal((await q.status()).scene, path);
    await assert.rejects(q.scene.load({ file: path, files: [path] }), { name: "ParameterError" }); // it has been passed on
    await assert.rejects(q.upload("../a.obj", mesh), { name: "ParameterError" });
    await live.q.scene.load({ file: live.scene });
  });

  it("shows a picture as a quilt", async (test) => {
    if (!live.q.info.methods["quilt.show"]) return test.skip("this quiltd has no quilt.show");
    await q.wait("complete", { timeout: 120 });
    const { jpeg, columns, rows } = await q.preview();
    const { generation } = await q.showQuilt(jpeg, { columns, rows });
    assert.deepEqual([(await q.status()).is_quilt, (await q.status()).generation], [true, generation]);
    await assert.rejects(q.showQuilt(jpeg.subarray(0, 100), { columns, rows }), { name: "BadScene" });
    await live.q.scene.load({ file: live.scene });
  });

  it("gives exports as bytes", async () => {
    const [still] = await q.export("still");
    assert.deepEqual([still.name, [...still.data.subarray(1, 4)]], ["still.png", [..."PNG"].map((c) => c.charCodeAt())]);
    const files = await q.export("print", { lpi: 60, width: 4, height: 3, dpi: 240, file: "card.tif" });
    assert.deepEqual(files.map(({ data }) => data.length > 0), [true, true]);
    await assert.rejects(q.export("quilt", { file: "a.gif" }), { name: /ParameterError|PathRefused/ });
  });

  it("tells a wrong token, and that nobody listens", async () => {
    const wrong = { name: "WrongToken", message: /^the token is missing or wrong; take the URL that quiltweb printed last$/ };
    for (const url of [live.url.slice(0, -1), live.url.split("#")[0]]) await assert.rejects(connect(url), wrong);
    await assert.rejects(connect("http://127.0.0.1:9/#0"), { name: "NoDaemon", message: /ECONNREFUSED/ });
    await assert.rejects(connect(join(live.folder, "nothing")), { name: "NoDaemon", message: /ENOENT/ });
  });

  it("is reached by ws: and, behind a server with TLS, by https: and wss:", async (test) => {
    const q = await connect(live.url.replace("http:", "ws:"));
    q.close();
    const noTls = { name: "NoDaemon", message: /does not answer with TLS; use http:/ };
    await assert.rejects(connect(live.url.replace("http:", "https:")), noTls);
    const silent = createPlainServer((socket) => socket.once("data", () => socket.end()));
    await new Promise((resolve) => silent.listen(0, "127.0.0.1", resolve));
    await assert.rejects(connect(`https://127.0.0.1:${silent.address().port}/#0`), noTls);
    silent.close();
    const files = ["-keyout", join(live.folder, "key"), "-out", join(live.folder, "cert")];
    const command = ["req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=localhost", "-days", "2", ...files];
    const made = await promisify(execFile)("openssl", command).catch((error) => error);
    if (made.code === "ENOENT") return test.skip("there is no openssl");
    const [key, cert] = await Promise.all(["key", "cert"].map((name) => readFile(join(live.folder, name))));
    const port = await freePort();
    const server = createServer({ key, cert }, (socket) => {
      const inner = connectTcp(port, "127.0.0.1");
      for (const end of [socket, inner]) end.on("error", () => {});
      socket.pipe(inner).pipe(socket);
    });
    await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
    const outer = `https://localhost:${server.address().port}`;
    await assert.rejects(connect(outer), { name: "NoDaemon", message: /self.signed/ });
    process.env.NODE_TLS_REJECT_UNAUTHORIZED = "0";
    const { quiltweb, url } = await startGateway(live.socket, `127.0.0.1:${port}`, "--public", outer);
    try {
      for (const where of [url, url.replace("https:", "wss:")]) {
        const q = await connect(where);
        assert.match((await q.upload("a.obj", Buffer.from("v 0 0 0\n"))).path, /a\.obj$/);
        q.close();
      }
      await assert.rejects(connect(url.replace("localhost", "127.0.0.1")), { name: "NoDaemon", message: /start it with --public https:/ });
    } finally {
      delete process.env.NODE_TLS_REJECT_UNAUTHORIZED;
      quiltweb.kill();
      server.close();
    }
  });

  it("refuses other URLs", async () => {
    for (const url of ["ftp://localhost/", "http://", "https://a b/"])
      await assert.rejects(connect(url), { name: "ParameterError", message: /is no URL of quiltweb, such as http:/ });
  });

  it("has a hint for files that were not passed", async () => {
    const { path } = await q.upload("a.obj", Buffer.from("v 0 0 0\n"));
    await assert.rejects(q.scene.load({ file: path }), { name: "PathRefused", message: /; put it there by q\.upload, and add files: \[path\]$/ });
  });

  it("is needed for images and files", async () => {
    await assert.rejects(live.q.images().next(), { name: "NotSupported", message: /connect to the URL of quiltweb/ });
    await assert.rejects(live.q.export("still"), { name: "NotSupported" });
    await assert.rejects(live.q.upload("a.glb", new Uint8Array()), { name: "NotSupported" });
  });
});

describe("examples", () => {
  const run = (name, env, input, ...args) => {
    const options = { cwd: live.folder, env: { ...process.env, ...env } };
    const running = promisify(execFile)(process.execPath, [examples + name, ...args], options);
    running.child.stdin.end(input);
    return running.then(({ stdout }) => stdout);
  };

  it("orbit.js turns once around", async () => {
    const lines = (await run("orbit.js", { QUILTD_SOCKET: live.socket }, "", "120")).trim().split("\n");
    assert.equal(lines.length, 3);
    assert.ok(lines.every((line) => /^generation \d+$/.test(line)), lines);
  });

  it("slider.js takes lines", async () => {
    assert.match(await run("slider.js", { QUILTD_URL: live.url }, "20\n30\n"), /^(shown: (complete|converged)\n){2}$/);
    assert.equal((await live.q.scene.get()).scene.camera.fov_y, 30);
  });

  it("turntable.js saves images", async () => {
    await run("turntable.js", { QUILTD_URL: live.url }, "", "2");
    for (const name of ["turn_0.jpg", "turn_1.jpg"])
      assert.equal((await readFile(join(live.folder, name))).readUInt16BE(0), 0xffd8);
  });

  it("have at most ten lines", async () => {
    for (const name of await readdir(examples)) {
      const lines = (await readFile(examples + name, "utf8")).split("\n").slice(2);
      assert.ok(lines.filter(Boolean).length <= 10, name);
    }
  });
});
