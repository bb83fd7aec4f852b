// Clients of quiltweb's services for other programs, for the soak: honest ones that count their answers, and hostile ones.

import { connect } from "node:net";
import { join } from "node:path";
import { setTimeout as nap } from "node:timers/promises";

import { encodeFrame } from "../../clients/js/quiltd/websocket.js";
import { freePort } from "../../clients/js/tests/live.js";

const REQ = Buffer.from("0053500000300000", "hex");
// {cmd: {info: {}}, bin: null}
const INFO = Buffer.from("80000001a263636d64a164696e666fa06362696ef6", "hex");
const KEPT_OPEN = 4;

const pick = (list) => list[Math.floor(Math.random() * list.length)];

// Where the services are, and the options of quiltweb that open them.
export async function chooseServices(folder) {
  const [bridge, events, webxr] = [await freePort(), await freePort(), await freePort()];
  const nng = join(folder, "nng");
  return { bridge, events, webxr, nng, options: [`--bridge=${bridge},${events}`, `--webxr=${webxr}`, `--nng=${nng}`] };
}

// A program of Bridge.
export async function askBridge({ bridge }, counts, running) {
  while (running()) {
    const answer = await fetch(`http://127.0.0.1:${bridge}/bridge_version`, { method: "PUT", body: "{}" });
    if ((await answer.json()).status.value === "Completion") counts.calls++;
    await nap(100);
  }
}

// As nng's client: one request after the other on one connection.
export function askByNng({ nng }, counts, running) {
  const length = Buffer.alloc(9);
  length[0] = 1;
  length.writeUInt32BE(INFO.length, 5);
  return new Promise((resolve, reject) => {
    const socket = connect(nng);
    let bytes = Buffer.alloc(0), greeted = false;
    const ask = () => socket.write(Buffer.concat([length, INFO]));
    socket.on("error", reject);
    socket.on("close", resolve);
    socket.on("connect", () => socket.write(REQ));
    socket.on("data", (data) => {
      bytes = Buffer.concat([bytes, data]);
      if (!greeted && bytes.length >= 8) {
        bytes = bytes.subarray(8);
        greeted = true;
        ask();
      }
      if (bytes.length < 9 || bytes.length < 9 + bytes.readUInt32BE(5)) return;
      bytes = bytes.subarray(9 + bytes.readUInt32BE(5));
      counts.calls++;
      setTimeout(() => (running() ? ask() : socket.end()), 100);
    });
  });
}

const request = (line, port, headers, body = "") =>
  Buffer.from(`${line} HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\n${headers.map((h) => `${h}\r\n`).join("")}\r\n${body}`);
const UPGRADE = ["Connection: Upgrade", "Upgrade: websocket", "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
  "Sec-WebSocket-Protocol: rep.sp.nanomsg.org"];
const lengthOf = (n) => [`Content-Length: ${n}`];
const BAD_CBOR = [Buffer.alloc(2000, 0x81), Buffer.from("bb7fffffffffffffff", "hex"), Buffer.from("5b7fffffffffffffff00", "hex"), Buffer.alloc(0)];
const withId = (cbor) => Buffer.concat([Buffer.from("80000001", "hex"), cbor]);

// What is sent to a port.
const TO_PORT = [
  (port) => request("PUT /insert_playlist_entry", port, lengthOf(1 << 30)),
  (port) => request("PUT /instance_playlist", port, lengthOf(60000), "[".repeat(60000)),
  (port) => request("PUT /play_playlist", port, lengthOf(100), "{"),
  (port) => request("POST /play_playlist", port, lengthOf(2), "{}"),
  (port) => request("GET /", port, ["Origin: https://evil.test"]),
  () => Buffer.from("GET / HTTP/1.1\r\nHost: evil.test\r\n\r\n"),
  () => Buffer.from("PUT /bridge_ver"),
  (port) => Buffer.concat([request("GET /driver", port, UPGRADE), encodeFrame(2, withId(pick(BAD_CBOR)))]),
  (port) => Buffer.concat([request("GET /driver", port, UPGRADE), encodeFrame(2, INFO).subarray(0, 9)]),
  (port) => Buffer.concat([request("GET /event_source", port, UPGRADE.slice(0, 4)), encodeFrame(1, Buffer.alloc(70000, 91))]),
];
const frameOf = (message) => Buffer.concat([Buffer.from("0100000000", "hex"), Buffer.from([0, 0, message.length >> 8, message.length & 255]), message]);
const TO_NNG = [
  () => Buffer.concat([REQ, frameOf(withId(pick(BAD_CBOR)))]),
  () => Buffer.concat([REQ, Buffer.from("01ffffffffffffffff80000001", "hex")]),
  () => Buffer.concat([REQ, ...Array.from({ length: 500 }, () => frameOf(INFO))]), // and reads nothing
  () => Buffer.from("GET / HTTP/1.1\r\n\r\n"),
  () => REQ.subarray(0, 3),
];

export async function annoyServices(services, counts, running) {
  const sockets = [];
  while (running()) {
    const port = pick([services.bridge, services.events, services.webxr, 0]);
    const socket = port ? connect(port, "127.0.0.1") : connect(services.nng);
    socket.on("error", () => {});
    socket.pause();
    socket.write(port ? pick(TO_PORT)(port) : pick(TO_NNG)());
    sockets.push(socket);
    if (sockets.length > KEPT_OPEN) sockets.shift().destroy();
    counts.hostile++;
    await nap(50);
  }
  for (const socket of sockets) socket.destroy();
}
