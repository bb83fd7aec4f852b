// A soak of the gateway: eight WebSockets, one of which reads slowly and one of which is hostile, beside 16 clients of the socket,
// honest and hostile programs at the services of other programs, and, with QUILTD_NODE, a browser. Everybody else goes on, and neither
// memory nor descriptors grow.
//
// SOAK_SECONDS (20): how long. The first quarter is without the slow and the hostile one, to compare with. SOAK_STRICT: judge the
// longest turn of quiltd's event thread, too, and more calls.

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { connect as connectTcp } from "node:net";
import { describe, it } from "node:test";
import { setTimeout as nap } from "node:timers/promises";

import { connect } from "../../clients/js/quiltd/node.js";
import { encodeFrame } from "../../clients/js/quiltd/websocket.js";
import { start } from "../../clients/js/tests/live.js";
import { annoyServices, askBridge, askByNng, chooseServices } from "./soak_services.js";

const SECONDS = Number(process.env.SOAK_SECONDS ?? 20);
const HONEST = 6, JSON_CLIENTS = 16, PROGRAMS = 2;
const WARM_SHARE = 0.3; // caches fill, and the slow and the hostile one have come
const GROWTH_KIB = { quiltd: 32 * 1024, quiltweb: 4 * 1024 };
const LEAST_SHARE = 0.25; // of the median of its kind, which each client has to reach
// Of the calls a second without the slow and the hostile one, which the others of each kind together have to keep.
const KEPT_SHARE = process.env.SOAK_STRICT ? 0.3 : 0.1;
const TURN_FACTOR = 4, TURN_SLACK_S = 0.01;

const pick = (list) => list[Math.floor(Math.random() * list.length)];
const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)] ?? 0;
const residentKib = (pid) => 4 * Number(readFileSync(`/proc/${pid}/statm`, "utf8").split(" ")[1]);
const descriptors = (pid) => readdirSync(`/proc/${pid}/fd`).length;

// ------------------------------------------------------------------------------------------------ clients --

// Calls one after the other. counts.calls: those that were answered.
async function call(q, counts, running, pause) {
  while (running()) {
    const kind = Math.random();
    if (kind < 0.8) await q.status();
    else if (kind < 0.9) await q.scene.get();
    else await q.camera.orbit({ yaw: 1 });
    counts.calls++;
    await nap(pause);
  }
}

async function watchImages(q, counts, running) {
  for await (const { jpeg } of q.images()) {
    assert.equal(jpeg[0], 0xff);
    counts.images++;
    if (!running()) break;
  }
}

// A WebSocket as bare TCP, after its handshake.
function openRaw(text) {
  const url = new URL(text), socket = connectTcp(url.port, url.hostname);
  const lines = ["GET /rpc HTTP/1.1", `Host: ${url.host}`, `Authorization: Bearer ${url.hash.slice(1)}`, "Connection: Upgrade",
    "Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ=="];
  socket.on("error", () => {});
  socket.write(`${lines.join("\r\n")}\r\n\r\n`);
  return new Promise((resolve) => {
    socket.once("data", () => resolve(socket));
    socket.once("close", () => resolve(socket));
  });
}
const request = (id, method) => encodeFrame(1, Buffer.from(JSON.stringify({ jsonrpc: "2.0", id, method })));

// Asks for much, and reads a little of it every second.
async function readSlowly(url, counts, running) {
  while (running()) {
    const socket = await openRaw(url);
    socket.pause();
    socket.write(request(0, "preview.start"));
    for (let i = 1; running() && !socket.destroyed && i < 60; i++) {
      // first as much as fills the buffers of both kernels
      if (socket.writableLength < 65536) for (let k = i === 1 ? 0 : 180; k < 200; k++) socket.write(request(i, "hello"));
      socket.write(request(i, "preview.ack"));
      socket.read(1024);
      counts.slow++;
      await nap(1000);
    }
    socket.destroy();
  }
}

const HOSTILE = {
  garbage: () => Buffer.from(Array.from({ length: 2000 }, () => Math.floor(256 * Math.random()))),
  "a huge length": () => Buffer.from([0x81, 0xff, 0x7f, 255, 255, 255, 255, 255, 255, 255, 1, 2, 3, 4, 5]),
  "a long message": () => encodeFrame(1, Buffer.alloc((1 << 20) + 1, 32)),
  "a binary message": () => encodeFrame(2, Buffer.alloc(1000)),
  "no mask": () => Buffer.from([0x81, 2, 0x7b, 0x7d]),
  "half a frame": () => encodeFrame(1, Buffer.alloc(5000)).subarray(0, 4000),
  "half a message": () => Buffer.from([0x01, 0x80, 0, 0, 0, 0]),
  "many pings": () => Buffer.concat(Array.from({ length: 2000 }, () => encodeFrame(9, Buffer.alloc(125)))),
  "no JSON": () => Buffer.concat(Array.from({ length: 500 }, () => encodeFrame(1, Buffer.from("[[[[")))),
  "other methods": () => Buffer.concat(["shutdown", "device.set", "rights.limit"].map((name) => request(1, name))),
  nothing: () => Buffer.alloc(0),
};

// Some of its sockets stay half open; the oldest of four is given up.
async function annoy(url, counts, running) {
  const sockets = [];
  while (running()) {
    const socket = await openRaw(url);
    socket.write(pick(Object.values(HOSTILE))());
    sockets.push(socket);
    if (sockets.length > 1) sockets.shift().destroy();
    counts.hostile++;
    await nap(100);
  }
  for (const socket of sockets) socket.destroy();
}

// A person who turns the scene now and then.
async function browse(url, counts, running) {
  const { newPage, startBrowser } = await import("./browser.js");
  const browser = await startBrowser();
  const { page } = await newPage(browser);
  await page.goto(url);
  while (running()) {
    await page.mouse.move(400, 300);
    await page.mouse.down();
    await page.mouse.move(420, 300, { steps: 4 });
    await page.mouse.up();
    counts.drags++;
    await nap(1000);
  }
  await browser.close();
}

// ---------------------------------------------------------------------------------------------------- run --

// The growth of medians from the beginning, when all is warm, to the end.
function growth(samples) {
  const warm = Math.floor(WARM_SHARE * samples.length), tenth = Math.ceil(samples.length / 10);
  const from = median(samples.slice(warm, warm + tenth)), to = median(samples.slice(-tenth));
  return { from, to, by: to - from };
}

async function run(live, services) {
  const counts = { slow: 0, hostile: 0, drags: 0 }, kib = { quiltd: [], quiltweb: [] };
  const end = performance.now() + 1000 * SECONDS, bad = performance.now() + 250 * SECONDS;
  const running = () => performance.now() < end;
  const clients = (n) => Array.from({ length: n }, () => ({ calls: 0, images: 0 }));
  const web = clients(HONEST), json = clients(JSON_CLIENTS), bridge = clients(PROGRAMS), nng = clients(PROGRAMS), opened = [];
  const open = async (where) => opened[opened.push(await connect(where)) - 1];
  const tasks = [];
  for (const one of web) {
    const q = await open(live.url);
    tasks.push(call(q, one, running, 50), watchImages(q, one, running));
  }
  for (const one of json) tasks.push(call(await open(live.socket), one, running, 100));
  for (const one of bridge) tasks.push(askBridge(services, one, running));
  for (const one of nng) tasks.push(askByNng(services, one, running));
  if (process.env.QUILTD_NODE) tasks.push(browse(live.url, counts, running));
  const allCalls = () => [web, json].map((list) => list.reduce((sum, { calls }) => sum + calls, 0));
  let quietTurn, quietCalls;
  tasks.push((async () => {
    while (performance.now() < bad) await nap(100);
    quietTurn = (await live.q.status()).longest_turn;
    quietCalls = allCalls();
    await Promise.all([readSlowly(live.url, counts, running), annoy(live.url, counts, running), annoyServices(services, counts, running)]);
  })());
  tasks.push((async () => {
    for (; running(); await nap(250)) for (const name in kib) kib[name].push(residentKib(live.pids[name]));
  })());
  await Promise.all(tasks);
  for (const q of opened) q.close();
  const kept = Math.min(...allCalls().map((calls, i) => (calls - quietCalls[i]) / 3 / quietCalls[i]));
  return { counts, kib, web, json, bridge, nng, kept, quietTurn, turn: (await live.q.status()).longest_turn };
}

// Until both programs have let go of what the clients held.
async function letGo(live, before) {
  const now = () => Object.values(live.pids).map(descriptors);
  for (let i = 0; i < 1200 && now().some((n, k) => n > before[k]); i++) await nap(50);
  return now();
}

describe("slow and hostile clients", () => {
  it("keep nobody waiting, and leave nothing", async () => {
    const options = ["--device", "sim:panel", "--view-size", "48x64", "--threads", "1", "--run-for", String(SECONDS + 1800)];
    let services;
    const live = await start({ options, web: async (folder) => (services = await chooseServices(folder)).options });
    try {
      await live.q.wait("complete");
      await (await connect(live.url)).close();
      const before = Object.values(live.pids).map(descriptors);
      const { counts, kib, web, json, bridge, nng, kept, quietTurn, turn } = await run(live, services);
      const after = await letGo(live, before);
      const least = (list, what) => Math.min(...list.map((one) => one[what]));
      const usual = (list, what) => median(list.map((one) => one[what]));
      const memory = Object.fromEntries(Object.entries(kib).map(([name, samples]) => [name, growth(samples)]));
      console.log(`# ${SECONDS} s; ${counts.slow} reads of the slow one, ${counts.hostile} attempts of the hostile one, ${counts.drags} drags`);
      console.log(`# calls a second: ${kept.toFixed(2)} of those without the two`);
      for (const [name, list, what] of [["WebSockets", web, "calls"], ["WebSockets", web, "images"], ["sockets", json, "calls"],
        ["programs of Bridge", bridge, "calls"], ["programs of nng", nng, "calls"]])
        console.log(`# ${list.length} ${name}: ${what} ${least(list, what)} at least, median ${usual(list, what)}`);
      for (const [name, { from, to }] of Object.entries(memory))
        console.log(`# ${name}: ${(from / 1024).toFixed(1)} MiB when warm, ${(to / 1024).toFixed(1)} at the end`);
      console.log(`# longest turn: ${(1e3 * quietTurn).toFixed(2)} ms without them, ${(1e3 * turn).toFixed(2)} with; descriptors ${before} before, ${after} after`);
      for (const [list, what] of [[web, "calls"], [web, "images"], [json, "calls"], [bridge, "calls"], [nng, "calls"]])
        assert.ok(least(list, what) > LEAST_SHARE * usual(list, what), `${what}: ${list.map((one) => one[what])}`);
      assert.ok(kept > KEPT_SHARE, `calls became ${kept} as many`);
      assert.ok(counts.slow > 0 && counts.hostile > 0);
      for (const [name, { by }] of Object.entries(memory)) assert.ok(by < GROWTH_KIB[name], `${name} grew by ${by} KiB`);
      assert.ok(after.every((n, i) => n <= before[i] + 1), `descriptors: ${before} before, ${after} after`); // a picture of the panel
      if (process.env.SOAK_STRICT) assert.ok(turn < TURN_FACTOR * quietTurn + TURN_SLACK_S, `a turn took ${turn} s`);
    } finally {
      await live.stop();
    }
  });
});
