// The client with a door of the test's own: what comes in another order, too late, or never.

import assert from "node:assert/strict";
import { createServer } from "node:net";
import { mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { describe, it } from "node:test";
import { setImmediate as turn } from "node:timers/promises";

import { Quiltd, connect, readImage } from "../quiltd/node.js";

const names = ["hello", "status", "subscribe", "camera.orbit", "export", "job.cancel", "scene.load"];
const HELLO = {
  methods: Object.fromEntries(names.map((name) => [name, {}])),
  events: { frame: { event: "frame" }, "scene.load": { event: "scene" }, scene: { event: "scene" } },
};

// A client, and `sent`: what it sent. answers: per method, the result; a function gets the params; undefined: no answer.
async function client(answers = {}, gateway) {
  const sent = [];
  const door = { closed: false, close: () => (door.closed = true), ...(gateway && { request: gateway }) };
  const say = (message) => door.received(JSON.stringify({ jsonrpc: "2.0", ...message }));
  door.send = (text) => {
    const { id, method, params } = JSON.parse(text);
    sent.push([method, params]);
    const answer = { hello: HELLO, subscribe: {}, "preview.start": {}, "preview.stop": {}, ...answers }[method];
    const result = typeof answer === "function" ? answer(params) : answer;
    if (id !== undefined && result !== undefined) queueMicrotask(() => say({ id, result }));
  };
  const q = await Quiltd.over(door);
  sent.length = 0;
  const notify = (method, params) => say({ method, params });
  return { q, door, sent, say, notify, methods: () => sent.map(([method]) => method) };
}

function image(generation) {
  const buffer = new ArrayBuffer(18);
  const data = new DataView(buffer);
  data.setUint32(0, generation, true);
  data.setUint8(4, 2);
  [3, 2, 6, 24, 32].forEach((value, i) => data.setUint16(6 + 2 * i, value, true));
  return buffer;
}

describe("calls", () => {
  it("are matched by id", async () => {
    const { q, say } = await client();
    const [one, two] = [q.call("a"), q.call("b")];
    say({ id: 3, result: "second" });
    say({ id: 2, result: "first" });
    assert.deepEqual(await Promise.all([one, two]), ["first", "second"]);
  });

  it("that were given up do not disturb later ones", async () => {
    const { q, say } = await client();
    await assert.rejects(q.call("slow", {}, { timeout: 0.01 }), { name: "TimedOut" });
    say({ id: 2, result: {} });
    const later = q.call("b");
    say({ id: 3, result: 1 });
    assert.equal(await later, 1);
  });

  it("fail when the connection ends, with its reason", async () => {
    const { q, door, say } = await client();
    const call = q.call("a"), events = q.events("frame");
    say({ id: null, error: { code: -32000, message: "too many clients" } });
    door.ended("");
    const closed = { name: "ConnectionClosed", message: "too many clients" };
    await assert.rejects(call, closed);
    await assert.rejects(q.call("b"), closed);
    await assert.rejects(events.next(), closed);
  });

  it("fail once the client is closed", async () => {
    const { q, door } = await client();
    q.close();
    await assert.rejects(q.call("a"), { name: "ConnectionClosed" });
    assert.ok(door.closed);
  });
});

describe("members", () => {
  it("that quiltd does not have fail when they are called, with the nearest", async () => {
    const { q, sent } = await client();
    const orbit = { name: "MethodNotFound", message: 'quiltd has no method camera.orbitt; did you mean "camera.orbit"?' };
    await assert.rejects(q.camera.orbitt({ yaw: 1 }), orbit);
    await assert.rejects(q.camra.orbit(), { name: "MethodNotFound", message: /camra\.orbit; did you mean "camera\.orbit"/ });
    await assert.rejects(q.stattus(), { message: /did you mean "status"/ });
    await assert.rejects(q.xyzzy(), { name: "MethodNotFound", message: "quiltd has no method xyzzy" });
    assert.deepEqual(sent, []);
  });

  it("that others look for are undefined", async () => {
    const { q } = await client();
    assert.equal(await q, q);
    for (const name of ["then", "toJSON", "nodeType", "_private", "$$typeof", Symbol.iterator])
      for (const object of [q, q.camera, q.camra]) assert.equal(object[name], undefined, String(name));
    assert.deepEqual([Object.keys(q.camera), `${q}`, "orbitt" in q.camera], [["orbit"], "[object Object]", false]);
  });
});

describe("files", () => {
  const never = () => assert.fail("nothing is sent");

  it("are bytes", async () => {
    const { q } = await client({}, never);
    const wrong = { name: "ParameterError", message: /^upload: expected the bytes of a file, as Uint8Array or Blob, not / };
    for (const data of [undefined, null, "text", 3, {}]) await assert.rejects(q.upload("a.obj", data), wrong);
    await assert.rejects(q.showQuilt("a.png", { columns: 8, rows: 6 }), { message: /^showQuilt: expected the bytes/ });
  });

  it("are sent as they are in memory", async () => {
    const bodies = [];
    const { q } = await client({}, (method, path, body) => {
      bodies.push([...body]);
      return { status: 200, data: new TextEncoder().encode("{}") };
    });
    await q.upload("a", new Uint16Array([1, 2, 3]).subarray(1));
    await q.upload("a", Buffer.from([7]));
    assert.deepEqual(bodies, [[2, 0, 3, 0], [7]]);
  });

  it("of quilts have tiles", async () => {
    const { q } = await client({}, never);
    const bytes = new Uint8Array(3);
    for (const tiles of [undefined, {}, { columns: 8 }])
      await assert.rejects(q.showQuilt(bytes, tiles), { name: "ParameterError", message: /give them as \{ columns: 8, rows: 6 \}/ });
    await assert.rejects(q.showQuilt(bytes, { cols: 8, rows: 6 }), { name: "ParameterError", message: /"cols"; the keys are columns/ });
  });

  it("that quiltd may not read have a hint", async () => {
    const error = { code: -32001, message: "/a;b: is outside; pass its descriptor, as quiltctl does" };
    const messages = [];
    for (const [gateway, params] of [[never, {}], [undefined, {}], [never, { files: ["/a;b"] }]]) {
      const { q, say } = await client({}, gateway);
      const call = q.call("scene.load", params);
      say({ id: 2, error });
      messages.push(await call.catch(({ message }) => message.slice(error.message.indexOf("; "))));
    }
    assert.match(messages[0], /^; put it there by q\.upload, and add files: \[path\]$/);
    assert.match(messages[1], /^; start quiltd with --allow-path/);
    assert.match(messages[2], /^; pass its descriptor/);
  });
});

describe("events", () => {
  it("are subscribed for all readers together", async () => {
    const { q, sent } = await client();
    const one = q.events("frame"), two = q.events("scene", "frame");
    one.return();
    two.return();
    assert.deepEqual(sent.map(([, { events }]) => events), [["frame"], ["frame", "scene"], ["scene", "frame"], []]);
  });

  it("of a word may have several names", async () => {
    const { q, notify } = await client();
    const events = q.events("scene");
    for (const name of ["scene.load", "frame", "scene"]) notify(name, {});
    const seen = [(await events.next()).value.name, (await events.next()).value.name];
    assert.deepEqual(seen, ["scene.load", "scene"]);
  });

  it("keep the newest 1024", async () => {
    const { q, notify } = await client();
    const events = q.events("frame");
    for (let i = 0; i < 1030; i++) notify("frame", { i });
    assert.equal((await events.next()).value.params.i, 6);
  });

  it("end for those that read already, and for those that do not", async () => {
    const { q, notify } = await client();
    const events = q.events("frame");
    const waiting = events.next();
    notify("frame", {});
    await waiting;
    const last = events.next();
    events.return();
    assert.equal((await last).done, true);
    assert.equal((await events.next()).done, true);
  });

  it("end with the error of subscribe", async () => {
    const { q, say } = await client({ subscribe: undefined });
    const events = q.events("frame");
    say({ id: 2, error: { code: -32602, message: "no" } });
    await assert.rejects(events.next(), { name: "ParameterError" });
  });
});

describe("images", () => {
  it("are acknowledged when the next one is asked for", async () => {
    const { q, door, methods } = await client({}, () => {});
    const images = q.images();
    const first = images.next();
    await turn();
    door.received(image(5));
    const { generation, level, columns, rows, views, width, height } = (await first).value;
    assert.deepEqual([generation, level, columns, rows, views, width, height], [5, "complete", 3, 2, 6, 24, 32]);
    assert.deepEqual(methods(), ["preview.start"]);
    const second = images.next();
    await turn();
    assert.deepEqual(methods(), ["preview.start", "preview.ack"]);
    door.received(image(6));
    assert.equal((await second).value.generation, 6);
    await images.return();
    assert.deepEqual(methods(), ["preview.start", "preview.ack", "preview.stop"]);
  });

  it("that come when nobody reads are dropped", async () => {
    const { q, door, methods } = await client({ status: {} }, () => {});
    door.received(image(1));
    await q.status();
    assert.deepEqual(methods(), ["status"]);
  });

  it("have a header of 16 bytes", () => {
    assert.equal(readImage(image(1 << 20)).generation, 1 << 20);
    assert.equal(readImage(image(1)).jpeg.length, 2);
  });
});

describe("files through the gateway", () => {
  const bytes = (text) => new TextEncoder().encode(text);

  it("are uploaded by name", async () => {
    const asked = [];
    const { q } = await client({}, async (...call) => {
      asked.push(call);
      return { status: 201, data: bytes('{"path":"/upload/1/a b.glb","folder":"1"}') };
    });
    const data = bytes("x");
    assert.deepEqual(await q.upload("a b.glb", data), { path: "/upload/1/a b.glb", folder: "1" });
    await q.upload("c.png", data, { folder: "1" });
    await q.showQuilt(data, { columns: 8, rows: 6, aspect: 0.75 });
    assert.deepEqual(asked.map(([method, path]) => `${method} ${path}`), [
      "PUT /api/upload?name=a+b.glb",
      "PUT /api/upload?name=c.png&folder=1",
      "PUT /api/quilt?cols=8&rows=6&aspect=0.75",
    ]);
  });

  it("that are refused say why", async () => {
    const answers = [
      { status: 422, data: bytes('{"error":{"code":-32002,"message":"quilt: no picture"}}') },
      { status: 413, data: bytes("the body is too long\n") },
      { status: 500, data: bytes("") },
    ];
    const { q } = await client({}, async () => answers.shift());
    const quilt = () => q.showQuilt(bytes("x"), { columns: 1, rows: 1 });
    await assert.rejects(quilt(), { name: "BadScene", message: "quilt: no picture" });
    await assert.rejects(quilt(), { message: /the body is too long$/ });
    await assert.rejects(quilt(), { message: /status 500 of HTTP$/ });
  });

  const download = { job: 4, files: [{ name: "a.png", bytes: 1, path: "/api/download/9/a.png" }] };

  it("are exported, also if the end comes before the answer", async () => {
    const { q, sent, notify } = await client(
      { export: () => (notify("export", { job: 3, state: "failed" }), notify("download", download), { job: 4 }) },
      async (method, path) => ({ status: 200, data: bytes(`${method} ${path}`) }),
    );
    const [file] = await q.export("still", { wait: "complete" });
    assert.deepEqual(sent[0], ["export", { kind: "still", file: "still.png", wait: "complete" }]);
    assert.deepEqual([file.name, new TextDecoder().decode(file.data)], ["a.png", "GET /api/download/9/a.png"]);
  });

  it("of an export that fails are an error, one too late ends the job", async () => {
    const { q, methods, notify } = await client({ export: { job: 4 }, "job.cancel": {} }, async () => {});
    const failed = q.export("panel");
    notify("export", { job: 4, state: "failed", error: { code: -32003, message: "no panel" } });
    await assert.rejects(failed, { name: "NoDevice", message: "no panel" });
    const cancelled = q.export("panel");
    notify("export", { job: 4, state: "cancelled" });
    await assert.rejects(cancelled, { name: "Cancelled" });
    const lost = q.export("panel");
    notify("export", { job: 4, state: "done" });
    notify("download", { job: 4, error: { code: -32603, message: "no memory" } });
    await assert.rejects(lost, { name: "InternalError", message: "no memory" });
    await assert.rejects(q.export("panel", { timeout: 0.01 }), { name: "TimedOut" });
    assert.deepEqual(methods(), ["export", "export", "export", "export", "job.cancel"]);
  });
});

describe("the socket", () => {
  it("may break lines and letters anywhere", async () => {
    const path = join(mkdtempSync(join(tmpdir(), "quiltd-js-")), "s");
    const server = createServer((socket) =>
      socket.on("data", async (data) => {
        const { id } = JSON.parse(data);
        const answer = Buffer.from(`${JSON.stringify({ id, result: { ...HELLO, name: "Grüße" } })}\n`);
        for (const byte of answer) {
          socket.write(Buffer.of(byte));
          if (byte > 127) await turn();
        }
      }),
    );
    await new Promise((resolve) => server.listen(path, resolve));
    const q = await connect(path);
    assert.equal(q.info.name, "Grüße");
    q.close();
    server.close();
  });
});
