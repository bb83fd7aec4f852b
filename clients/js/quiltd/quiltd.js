// A client of quiltd, and its door for browsers. Needs no other file; node.js adds the doors of Node.
//
// A door carries messages: send(text), close(), and request(method, path, body) for HTTP. It calls
// received(data) with a text or an ArrayBuffer, and ended(reason) once.

const KEPT = 1024; // events that nobody has read
const HEADER = 16;
const LEVELS = ["none", "coarse", "complete", "converged"];
const NAMES = {
  [-32601]: "MethodNotFound",
  [-32602]: "ParameterError",
  [-32603]: "InternalError",
  [-32000]: "Busy",
  [-32001]: "PathRefused",
  [-32002]: "BadScene",
  [-32003]: "NoDevice",
  [-32004]: "TimedOut",
};

// What went wrong. `name` says it in a word; `code` and `data` are those of the answer, if there was one.
export class QuiltdError extends Error {
  constructor(message, { name, code, data } = {}) {
    super(message);
    this.name = name ?? NAMES[code] ?? "QuiltdError";
    this.code = code;
    this.data = data;
  }
}

const refused = (error) => new QuiltdError(error.message, { code: error.code, data: error.data });
const wrong = (message) => new QuiltdError(message, { name: "ParameterError" });

// The number of letters to insert, remove or replace.
function distance(a, b) {
  let row = [...Array(b.length + 1).keys()];
  for (let i = 1; i <= a.length; i++) {
    const above = row;
    row = [i];
    for (let j = 1; j <= b.length; j++)
      row[j] = Math.min(above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] === b[j - 1] ? 0 : 1));
  }
  return row[b.length];
}

// The end of a message: the nearest of these words, if one is near.
function meant(word, words) {
  const [best] = words.map((known) => [distance(word, known), known]).sort((a, b) => a[0] - b[0]);
  return best && best[0] <= Math.max(1, word.length / 4) ? `; did you mean "${best[1]}"?` : "";
}

// What JavaScript itself, consoles and frameworks look for.
const foreign = (name) => typeof name !== "string" || name === "then" || name === "toJSON" || !/^[a-z][a-z_]*$/.test(name);

// A prototype on which each name that there is not becomes unknown(name).
const guessing = (unknown) =>
  new Proxy(Object.prototype, {
    get: (object, name, receiver) => (name in object || foreign(name) ? object[name] : unknown(name, receiver)),
  });

// A member that quiltd does not have: a call of it fails, q.camera.orbitt() as well as q.camra.orbit().
function unknownMember(q, path) {
  const fail = async () => {
    const near = meant(path, Object.keys(q.info?.methods ?? {}));
    throw new QuiltdError(`quiltd has no method ${path}${near}`, { name: "MethodNotFound" });
  };
  const get = (object, name) => (name in object || foreign(name) ? object[name] : unknownMember(q, `${path}.${name}`));
  return new Proxy(fail, { get });
}

// The bytes of a file as they are sent.
function fileOf(what, data) {
  if (data instanceof Blob) return data;
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  throw wrong(`${what}: expected the bytes of a file, as Uint8Array or Blob, not ${data === null ? "null" : typeof data}`);
}

// A hint for files that quiltd may not read, or undefined.
function hintOf(method, params, gateway) {
  if ((method !== "scene.load" && method !== "scene.patch") || params?.files) return undefined;
  return gateway ? "put it there by q.upload, and add files: [path]" : "start quiltd with --allow-path, or connect to quiltweb";
}

// An image message of quiltweb (docs/reference/protocol.md, Gateway).
export function readImage(buffer) {
  const data = new DataView(buffer);
  return {
    generation: data.getUint32(0, true),
    level: LEVELS[data.getUint8(4)],
    columns: data.getUint16(6, true),
    rows: data.getUint16(8, true),
    views: data.getUint16(10, true),
    width: data.getUint16(12, true),
    height: data.getUint16(14, true),
    jpeg: new Uint8Array(buffer, HEADER),
  };
}

// What comes for one reader: an async iterator, which ends by end() or after `timeout` seconds without a value.
class Inbox {
  #values = [];
  #readers = [];
  #over; // undefined, or { error }
  #timeout;
  #left;

  // left: called once, when nobody reads any more.
  constructor(timeout, left) {
    this.#timeout = timeout;
    this.#left = left;
  }

  push(value) {
    const reader = this.#readers.shift();
    if (reader) return reader.resolve({ value, done: false });
    if (this.#values.length === KEPT) this.#values.shift();
    this.#values.push(value);
  }

  end(error) {
    if (this.#over) return;
    this.#over = { error };
    for (const reader of this.#readers.splice(0))
      error ? reader.reject(error) : reader.resolve({ value: undefined, done: true });
    this.#left?.();
  }

  next() {
    if (this.#values.length > 0) return Promise.resolve({ value: this.#values.shift(), done: false });
    if (this.#over?.error) return Promise.reject(this.#over.error);
    if (this.#over) return Promise.resolve({ value: undefined, done: true });
    return new Promise((resolve, reject) => {
      const timer = this.#timeout && setTimeout(() => this.end(), 1000 * this.#timeout);
      this.#readers.push({
        resolve: (value) => (clearTimeout(timer), resolve(value)),
        reject: (error) => (clearTimeout(timer), reject(error)),
      });
    });
  }

  return() {
    this.#values = [];
    this.end();
    return Promise.resolve({ value: undefined, done: true });
  }

  [Symbol.asyncIterator]() {
    return this;
  }
}

// A connection. Every method that quiltd's `hello` lists is a member: q.status(), q.camera.orbit({ yaw: 15 }).
export class Quiltd {
  #door;
  #calls = new Map();
  #ids = 0;
  #listeners = new Set(); // { wants, inbox, words }
  #images;
  #closed;

  // `info` is the answer of `hello`.
  static async over(door) {
    const q = new Quiltd();
    q.#door = door;
    door.received = (data) => q.#receive(data);
    door.ended = (reason) => q.#end(reason || "quiltd closed the connection");
    q.info = await q.call("hello");
    q.#addMethods();
    return q;
  }

  // The result of a method by its name. timeout: seconds to wait for the answer.
  call(method, params = {}, { timeout } = {}) {
    if (this.#closed) return Promise.reject(this.#closed);
    const id = ++this.#ids;
    this.#door.send(JSON.stringify({ jsonrpc: "2.0", id, method, params }));
    const hint = hintOf(method, params, this.#door.request);
    return new Promise((resolve, reject) => {
      const late = () => {
        this.#calls.delete(id);
        reject(new QuiltdError(`${method}: no answer within ${timeout} s`, { name: "TimedOut" }));
      };
      this.#calls.set(id, { resolve, reject, hint, timer: timeout && setTimeout(late, 1000 * timeout) });
    });
  }

  // A call without an answer.
  notify(method, params) {
    if (!this.#closed) this.#door.send(JSON.stringify({ jsonrpc: "2.0", method, params }));
  }

  close() {
    this.#end("the connection is closed");
    this.#door.close();
  }

  // Until the panel shows the newest generation, or this one: coarse, complete or converged. timeout: seconds.
  wait(level = "coarse", { generation, timeout } = {}) {
    return this.call("wait", { for: level, generation, timeout });
  }

  // Notifications of these events from now on: for await (const { name, params } of q.events("frame")).
  // The last argument may be { timeout }: it ends after so many seconds without an event.
  events(...words) {
    const { timeout } = typeof words.at(-1) === "object" ? words.pop() : {};
    const known = Object.entries(this.info.events);
    const all = [...new Set(known.map(([, about]) => about.event))];
    const unknown = words.filter((word) => !all.includes(word));
    if (unknown.length > 0)
      throw new QuiltdError(`events: unknown ${unknown}; quiltd has ${all}`, { name: "ParameterError" });
    const wanted = words.length > 0 ? words : all;
    const names = known.filter(([, about]) => wanted.includes(about.event)).map(([name]) => name);
    const inbox = this.#listen((name) => names.includes(name), wanted, timeout);
    this.#subscribe().catch((error) => inbox.end(error));
    return inbox;
  }

  // Images that the panel shows, each { generation, level, columns, rows, views, width, height, jpeg }: a quilt
  // with view 0 at the bottom left. The next one is asked for when the reader asks for it.
  async *images() {
    this.#needGateway("images");
    if (this.#images) throw new QuiltdError("images: another reader has them", { name: "Busy" });
    const inbox = (this.#images = new Inbox());
    try {
      await this.call("preview.start");
      for await (const image of inbox) {
        yield readImage(image);
        this.notify("preview.ack");
      }
    } finally {
      this.#images = undefined;
      this.notify("preview.stop");
    }
  }

  // The image that is shown now.
  async preview() {
    for await (const image of this.images()) return image;
  }

  // Puts bytes (a Uint8Array, a Blob, a File) where scene.load finds them: q.scene.load({ file: path, files: [path] }).
  // folder: that of an earlier upload. Returns { path, folder }.
  async upload(name, data, { folder } = {}) {
    const body = fileOf("upload", data);
    return JSON.parse(text(await this.#http("PUT", address("/api/upload", { name, folder }), body)));
  }

  // Shows a picture file as a quilt: { columns, rows, views, aspect }.
  async showQuilt(picture, tiles = {}) {
    const { columns: cols, rows, views, aspect, ...others } = tiles;
    const [other] = Object.keys(others);
    if (other) throw wrong(`showQuilt: unknown key "${other}"; the keys are columns, rows, views and aspect`);
    if (cols === undefined || rows === undefined)
      throw wrong("showQuilt: the tiles are missing; give them as { columns: 8, rows: 6 }");
    const body = fileOf("showQuilt", picture);
    return JSON.parse(text(await this.#http("PUT", address("/api/quilt", { cols, rows, views, aspect }), body)));
  }

  // What `quiltctl export` writes, as [{ name, data }]. params: those of the method export; file chooses the format.
  // timeout: seconds until TimedOut, which ends the export.
  async export(kind = "quilt", { timeout, ...params } = {}) {
    this.#needGateway("export");
    const inbox = this.#listen((name) => name === "export" || name === "download", []);
    const timer = timeout && setTimeout(() => inbox.end(), 1000 * timeout);
    const ending = { print: ".tif", chart: ".tif", state: ".lfstate" }[kind] ?? ".png";
    try {
      const { job } = await this.call("export", { kind, file: kind + ending, ...params });
      const files = await this.#exported(job, inbox);
      const load = async ({ name, path }) => ({ name, data: await this.#http("GET", path) });
      return await Promise.all(files.map(load));
    } finally {
      clearTimeout(timer);
      inbox.end();
    }
  }

  async #exported(job, inbox) {
    for await (const { name, params } of inbox) {
      if (params.job !== job) continue;
      if (params.files) return params.files;
      if (name === "download") throw refused(params.error);
      if (params.state === "cancelled")
        throw new QuiltdError(`export: job ${job} was cancelled`, { name: "Cancelled" });
      if (params.state === "failed") throw refused(params.error ?? { message: "export: failed" });
    }
    this.call("job.cancel", { job }).catch(() => {});
    throw new QuiltdError(`export: job ${job} is not done in time`, { name: "TimedOut" });
  }

  #needGateway(what) {
    if (this.#door.request) return;
    const why = "a Unix socket passes descriptors, which Node cannot; connect to the URL of quiltweb";
    throw new QuiltdError(`${what}: ${why}`, { name: "NotSupported" });
  }

  async #http(method, path, body) {
    this.#needGateway(path);
    const { status, data } = await this.#door.request(method, path, body);
    if (status < 300) return data;
    let error = { message: `${path}: ${text(data).trim() || `status ${status} of HTTP`}` };
    try {
      error = JSON.parse(text(data)).error ?? error;
    } catch {
      // a line in plain words
    }
    throw refused(error);
  }

  #addMethods() {
    for (const name of Object.keys(this.info.methods)) {
      const words = name.split("."), last = words.pop();
      const group = words.reduce((at, word, i) => this.#group(at, word, words.slice(0, i + 1).join(".")), this);
      if (!(last in group)) group[last] = (params) => this.call(name, params);
    }
  }

  #group(at, word, path) {
    if (!(word in at)) at[word] = Object.create(guessing((name) => unknownMember(this, `${path}.${name}`)));
    return at[word];
  }

  #listen(wants, words, timeout) {
    const listener = { wants, words };
    const left = () => {
      if (this.#listeners.delete(listener) && words.length > 0) this.#subscribe().catch(() => {});
    };
    listener.inbox = new Inbox(timeout, left);
    this.#listeners.add(listener);
    return listener.inbox;
  }

  #subscribe() {
    const events = new Set([...this.#listeners].flatMap(({ words }) => words));
    return this.call("subscribe", { events: [...events] });
  }

  #receive(data) {
    if (typeof data !== "string") return this.#images?.push(data);
    const { id, method, params, result, error } = JSON.parse(data);
    if (method) {
      for (const { wants, inbox } of this.#listeners) if (wants(method)) inbox.push({ name: method, params });
      return;
    }
    const call = this.#calls.get(id);
    if (error && id === null) this.#end(error.message); // why quiltd closes the connection next
    clearTimeout(call?.timer);
    this.#calls.delete(id);
    if (error?.code === -32001 && call?.hint) error.message = `${error.message.replace(/; pass its descriptor.*$/, "")}; ${call.hint}`;
    if (error) call?.reject(refused(error));
    else call?.resolve(result);
  }

  #end(reason) {
    if (this.#closed) return;
    this.#closed = new QuiltdError(reason, { name: "ConnectionClosed" });
    for (const { reject, timer } of this.#calls.values()) clearTimeout(timer), reject(this.#closed);
    this.#calls.clear();
    for (const { inbox } of [...this.#listeners]) inbox.end(this.#closed);
    this.#images?.end(this.#closed);
  }
}

Object.setPrototypeOf(
  Quiltd.prototype,
  guessing((name, q) => unknownMember(q, name)),
);

const text = (data) => new TextDecoder().decode(data);

function address(path, query) {
  const given = Object.entries(query).filter(([, value]) => value !== undefined);
  return `${path}?${new URLSearchParams(given)}`;
}

// A door to the quiltweb that served this page.
function openWebSocket() {
  const socket = new WebSocket(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/rpc`);
  socket.binaryType = "arraybuffer";
  const door = {
    send: (message) => socket.send(message),
    close: () => socket.close(),
    async request(method, path, body) {
      const answer = await fetch(path, { method, body });
      return { status: answer.status, data: new Uint8Array(await answer.arrayBuffer()) };
    },
  };
  return new Promise((resolve, reject) => {
    socket.onopen = () => resolve(door);
    socket.onmessage = ({ data }) => door.received?.(data);
    socket.onclose = ({ reason }) => {
      door.ended?.(reason);
      reject(new QuiltdError("quiltweb does not answer; open the URL that it printed", { name: "NoDaemon" }));
    };
  });
}

// A client of the quiltd whose page this is.
export async function connect() {
  return Quiltd.over(await openWebSocket());
}
