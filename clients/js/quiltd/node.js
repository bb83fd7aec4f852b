// The client in Node: over the socket of quiltd, or over quiltweb with the token of its URL.

import { connect as connectSocket } from "node:net";

import { Quiltd, QuiltdError } from "./quiltd.js";
import { openWebSocket, requestOf } from "./websocket.js";

export { Quiltd, QuiltdError, readImage } from "./quiltd.js";

// Where a daemon may listen, in the order of quiltctl.
function sockets() {
  const { QUILTD_SOCKET, XDG_RUNTIME_DIR } = process.env;
  const found = QUILTD_SOCKET ? [QUILTD_SOCKET] : [];
  if (XDG_RUNTIME_DIR?.startsWith("/")) found.push(`${XDG_RUNTIME_DIR}/quiltd.sock`);
  return [...found, "/run/quiltd/control.sock"];
}

// One JSON object per line.
function openSocket(path) {
  const socket = connectSocket(path);
  const door = { send: (text) => socket.write(`${text}\n`), close: () => socket.end() };
  let begun = ""; // of a line
  socket.setEncoding("utf8");
  socket.on("data", (data) => {
    const lines = (begun + data).split("\n");
    begun = lines.pop();
    for (const line of lines) door.received?.(line);
  });
  socket.on("close", () => door.ended?.());
  return new Promise((resolve, reject) => {
    socket.on("connect", () => resolve(door));
    socket.on("error", reject);
  });
}

async function openAny(paths) {
  const reasons = [];
  for (const path of paths) {
    try {
      return await openSocket(path);
    } catch (error) {
      reasons.push(`${path}: ${error.code}`);
    }
  }
  throw new Error(reasons.join("; "));
}

// Whole answers of HTTP. fetch would do, except that its headers differ from version to version.
function ask(url, headers, method, body = new Uint8Array()) {
  return new Promise((resolve, reject) => {
    const length = { "Content-Length": body.length };
    const call = requestOf(url)(url, { method, agent: false, headers: { ...headers, ...(method === "PUT" && length) } });
    call.on("error", reject);
    call.on("response", async (answer) => {
      const parts = [];
      answer.on("error", reject);
      answer.on("data", (part) => parts.push(part));
      answer.on("end", () => resolve({ status: answer.statusCode, data: new Uint8Array(Buffer.concat(parts)) }));
    });
    call.end(method === "PUT" ? body : undefined);
  });
}

async function openGateway(url) {
  const headers = { Authorization: `Bearer ${url.hash.slice(1)}` };
  const door = await openWebSocket(new URL("/rpc", url), headers);
  door.request = async (method, path, body) =>
    ask(new URL(path, url), headers, method, body instanceof Blob ? new Uint8Array(await body.arrayBuffer()) : body);
  return door;
}

function unopened(error, url) {
  if (error.status === 401)
    return new QuiltdError("the token is missing or wrong; take the URL that quiltweb printed last", { name: "WrongToken" });
  if (error.status === 421)
    return new QuiltdError("quiltweb refuses this host name; start it with --public https://NAME", { name: "NoDaemon" });
  // quiltweb answers a TLS greeting in plain text and hangs up; which of the two is seen first is a race
  const noTls = url?.protocol === "https:" && ["EPROTO", "ECONNRESET", "EPIPE"].includes(error.code);
  const why = noTls ? "the server does not answer with TLS; use http:// for quiltweb itself" : error.message;
  return new QuiltdError(`no quiltd answers: ${why}`, { name: "NoDaemon" });
}

function addressOf(text) {
  try {
    return new URL(text.replace(/^ws/i, "http"));
  } catch {
    return undefined;
  }
}

// A client of quiltd. where: the path of its socket, or the URL that quiltweb printed (http://127.0.0.1:8033/#TOKEN),
// also with https:, ws: or wss:. Without it: the socket that quiltctl would take.
export async function connect(where) {
  const [, scheme] = where?.match(/^([a-z]+):\/\//i) ?? [];
  const url = scheme && addressOf(where);
  if (scheme && !/^https?:$/.test(url?.protocol))
    throw new QuiltdError(`connect: ${where} is no URL of quiltweb, such as http://127.0.0.1:8033/#TOKEN`, { name: "ParameterError" });
  const opened = url ? openGateway(url) : openAny(where ? [where] : sockets());
  const door = await opened.catch((error) => {
    throw unopened(error, url);
  });
  return Quiltd.over(door);
}
