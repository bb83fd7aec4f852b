// A WebSocket client (RFC 6455) that can send a token: that of Node 18 to 21 does not exist, that of browsers sends none.

import { createHash, randomBytes } from "node:crypto";
import { request as requestHttp } from "node:http";
import { request as requestHttps } from "node:https";

const GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";
const TEXT = 1, BINARY = 2, CLOSE = 8, PING = 9, PONG = 10;
const LONGEST = 32 << 20; // of a message

// A frame as clients send it.
export function encodeFrame(opcode, payload, mask = randomBytes(4)) {
  const n = payload.length;
  const size = n < 126 ? 2 : n < 65536 ? 4 : 10;
  const frame = Buffer.alloc(size + 4 + n);
  frame[0] = 0x80 | opcode;
  frame[1] = 0x80 | (size === 2 ? n : size === 4 ? 126 : 127);
  if (size === 4) frame.writeUInt16BE(n, 2);
  else if (size === 10) frame.writeBigUInt64BE(BigInt(n), 2);
  mask.copy(frame, size);
  for (let i = 0; i < n; i++) frame[size + 4 + i] = payload[i] ^ mask[i & 3];
  return frame;
}

// Takes bytes as they come and calls message(opcode, payload) for each whole message and control frame.
// What a server must not send throws.
export class Decoder {
  #bytes = Buffer.alloc(0);
  #parts = [];
  #opcode = 0;
  #size = 0;
  #message;

  constructor(message) {
    this.#message = message;
  }

  take(bytes) {
    this.#bytes = this.#bytes.length > 0 ? Buffer.concat([this.#bytes, bytes]) : bytes;
    for (let used = this.#frame(); used > 0; used = this.#frame()) this.#bytes = this.#bytes.subarray(used);
  }

  // The number of bytes of the first frame; 0: it is not all there.
  #frame() {
    const bytes = this.#bytes;
    if (bytes.length < 2) return 0;
    const opcode = bytes[0] & 15, short = bytes[1] & 127;
    if ((bytes[0] & 0x70) !== 0 || bytes[1] >= 128 || (opcode >= CLOSE && (short > 125 || bytes[0] < 128)))
      throw new Error("the server sent a wrong frame");
    const begin = short < 126 ? 2 : short === 126 ? 4 : 10;
    if (bytes.length < begin) return 0;
    const n = begin === 2 ? short : begin === 4 ? bytes.readUInt16BE(2) : Number(bytes.readBigUInt64BE(2));
    if (this.#size + n > LONGEST) throw new Error("the server sent a message that is too long");
    if (bytes.length < begin + n) return 0;
    const payload = bytes.subarray(begin, begin + n);
    if (opcode >= CLOSE) this.#message(opcode, payload);
    else this.#part(opcode, payload, bytes[0] >= 128);
    return begin + n;
  }

  #part(opcode, payload, last) {
    if (opcode > BINARY || (opcode === 0) !== this.#parts.length > 0) throw new Error("the server sent a wrong frame");
    this.#opcode = opcode || this.#opcode;
    this.#parts.push(payload);
    this.#size += payload.length;
    if (!last) return;
    const parts = this.#parts.splice(0);
    this.#size = 0;
    this.#message(this.#opcode, Buffer.concat(parts));
  }
}

function follow(socket, head) {
  const door = { send: (text) => socket.write(encodeFrame(TEXT, Buffer.from(text))), close: () => socket.end() };
  let reason = "";
  const decoder = new Decoder((opcode, payload) => {
    if (opcode === TEXT) door.received?.(payload.toString());
    else if (opcode === BINARY) door.received?.(payload.buffer.slice(payload.byteOffset, payload.byteOffset + payload.length));
    else if (opcode === PING) socket.write(encodeFrame(PONG, payload));
    else if (opcode === CLOSE) {
      reason = payload.subarray(2).toString();
      socket.end(encodeFrame(CLOSE, payload.subarray(0, 2)));
    }
  });
  const take = (bytes) => {
    try {
      decoder.take(bytes);
    } catch (error) {
      reason = error.message;
      socket.destroy();
    }
  };
  socket.on("data", take);
  socket.on("error", () => {}); // close follows
  socket.on("close", () => door.ended?.(reason));
  // once the caller listens
  setImmediate(() => head.length > 0 && take(head));
  return door;
}

// What asks at a URL of http: or https:.
export const requestOf = (url) => (url.protocol === "https:" ? requestHttps : requestHttp);

// A promise of a door (quiltd.js) without `request`. headers: those of the handshake, such as Authorization.
export function openWebSocket(url, headers) {
  const key = randomBytes(16).toString("base64");
  const wanted = { Connection: "Upgrade", Upgrade: "websocket", "Sec-WebSocket-Version": 13, "Sec-WebSocket-Key": key };
  const accept = createHash("sha1").update(key + GUID).digest("base64");
  return new Promise((resolve, reject) => {
    const call = requestOf(url)(url, { agent: false, headers: { ...headers, ...wanted } });
    call.on("error", reject);
    call.on("response", (answer) => {
      answer.destroy();
      const refused = new Error(`${url.host} refused the WebSocket with status ${answer.statusCode}`);
      reject(Object.assign(refused, { status: answer.statusCode }));
    });
    call.on("upgrade", (answer, socket, head) => {
      if (answer.headers["sec-websocket-accept"] === accept) return resolve(follow(socket, head));
      socket.destroy();
      reject(new Error(`${url.host} is no WebSocket server`));
    });
    call.end();
  });
}
