// Frames of RFC 6455, and servers that do what they must not.

import assert from "node:assert/strict";
import { createHash } from "node:crypto";
import { createServer } from "node:net";
import { describe, it } from "node:test";

import { Decoder, encodeFrame, openWebSocket } from "../quiltd/websocket.js";

const bytes = (...values) => Buffer.from(values);

// What a decoder tells of these pieces.
function decode(...pieces) {
  const told = [];
  const decoder = new Decoder((opcode, payload) => told.push([opcode, payload.toString()]));
  for (const piece of pieces) decoder.take(piece);
  return told;
}

// A server that answers a handshake with `answer(accept)`, then sends these bytes; received: what came after it.
async function serve(answer, then) {
  const received = [];
  const server = createServer((socket) => {
    socket.unref(); // the client ends it
    let asked = "";
    socket.on("error", () => {});
    socket.on("data", (data) => {
      if (asked.includes("\r\n\r\n")) return received.push(data);
      asked += data;
      const key = /Sec-WebSocket-Key: (.*)\r\n/.exec(asked)[1];
      const accept = createHash("sha1").update(`${key}258EAFA5-E914-47DA-95CA-C5AB0DC85B11`).digest("base64");
      socket.write(Buffer.concat([Buffer.from(answer(accept)), then ?? Buffer.alloc(0)]));
    });
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: new URL(`http://127.0.0.1:${server.address().port}/rpc`), received, server };
}
const upgraded = (accept) =>
  `HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`;

// Why the door ended, and what came through it.
async function listen(then) {
  const { url, received, server } = await serve(upgraded, then);
  const door = await openWebSocket(url, {});
  const told = [];
  door.received = (data) => told.push(data);
  const reason = await new Promise((resolve) => (door.ended = resolve));
  server.close();
  return { reason, told, received };
}

describe("frames", () => {
  it("are those of the examples of RFC 6455", () => {
    const hello = bytes(0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58);
    assert.deepEqual(encodeFrame(1, Buffer.from("Hello"), bytes(0x37, 0xfa, 0x21, 0x3d)), hello);
    assert.deepEqual(decode(bytes(0x81, 5, 0x48, 0x65, 0x6c, 0x6c, 0x6f)), [[1, "Hello"]]);
    const parts = bytes(0x01, 3, 0x48, 0x65, 0x6c, 0x80, 2, 0x6c, 0x6f);
    assert.deepEqual(decode(parts), [[1, "Hello"]]);
  });

  it("have lengths of 7, 16 and 64 bits", () => {
    for (const [n, size] of [[0, 6], [125, 6], [126, 8], [65535, 8], [65536, 14]]) {
      const frame = encodeFrame(2, Buffer.alloc(n, 7), bytes(0, 0, 0, 0));
      assert.equal(frame.length, size + n);
      // what a server sends has no mask
      const head = Buffer.from(frame.subarray(0, size - 4));
      head[1] &= 127;
      assert.deepEqual(decode(head, frame.subarray(size)), [[2, String.fromCharCode(7).repeat(n)]]);
    }
  });

  it("may come byte by byte, with a ping between parts", () => {
    const all = bytes(0x01, 1, 0x61, 0x89, 1, 0x70, 0x80, 1, 0x62, 0x81, 0);
    assert.deepEqual(decode(...[...all].map((byte) => bytes(byte))), [[9, "p"], [1, "ab"], [1, ""]]);
  });

  it("that a server must not send are refused", () => {
    const wrong = {
      "a mask": bytes(0x81, 0x80, 0, 0, 0, 0),
      "a reserved bit": bytes(0xc1, 0),
      "a reserved opcode": bytes(0x83, 0),
      "a long ping": bytes(0x89, 126, 0, 126),
      "a ping in parts": bytes(0x09, 0),
      "a part of nothing": bytes(0x80, 0),
      "a message within another": bytes(0x01, 0, 0x81, 0),
      "a huge length": bytes(0x82, 127, 255, 255, 255, 255, 255, 255, 255, 255),
    };
    for (const [name, frame] of Object.entries(wrong)) assert.throws(() => decode(frame), /the server sent/, name);
  });

  it("of one message are not longer than others", () => {
    const part = Buffer.concat([bytes(0, 127, 0, 0, 0, 0, 1, 0, 0, 0), Buffer.alloc(1 << 24)]);
    const first = Buffer.from(part);
    first[0] = 2;
    assert.throws(() => decode(first, part, part), /too long/);
  });
});

describe("a WebSocket", () => {
  it("takes what comes with the handshake, and the reason of the end", async () => {
    const then = Buffer.concat([bytes(0x81, 2, 0x68, 0x69, 0x89, 1, 0x70, 0x88, 5, 0x03, 0xe9), Buffer.from("bye")]);
    const { reason, told, received } = await listen(then);
    assert.deepEqual([reason, told], ["bye", ["hi"]]);
    const sent = Buffer.concat(received);
    assert.deepEqual([sent[0], sent[1]], [0x8a, 0x81]); // a masked pong
    assert.deepEqual([sent[7], sent[8]], [0x88, 0x82]); // and a close
  });

  it("ends at a wrong frame", async () => {
    assert.match((await listen(bytes(0x83, 0))).reason, /wrong frame/);
  });

  it("refuses another answer than that of its key", async () => {
    const answers = { "is no WebSocket server": () => upgraded("no"), "status 401": () => "HTTP/1.1 401 No\r\n\r\n" };
    for (const [words, answer] of Object.entries(answers)) {
      const { url, server } = await serve(answer);
      await assert.rejects(openWebSocket(url, {}), new RegExp(words));
      server.close();
    }
  });
});
