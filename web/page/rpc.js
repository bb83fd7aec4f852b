// JSON-RPC over the WebSocket of quiltweb.

export class RpcError extends Error {
  constructor({ code, message }) {
    super(message);
    this.code = code;
  }
}

// Connects again by itself. Dispatches `open`, `close` (detail: the reason), `image` (detail: an
// ArrayBuffer) and, for each notification, an event of its name (detail: its params).
export class Rpc extends EventTarget {
  #socket;
  #calls = new Map();
  #ids = 0;
  #wait = 250;

  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/rpc`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#socket = socket;
      this.#tell("open");
    };
    socket.onmessage = ({ data }) => {
      this.#wait = 250; // not at open: quiltweb opens even if it then finds no quiltd
      if (typeof data === "string") this.#take(JSON.parse(data));
      else this.#tell("image", data);
    };
    socket.onclose = ({ reason }) => this.#lose(reason);
  }

  // A promise of the result; an RpcError if quiltd or quiltweb refuses.
  call(method, params = {}) {
    if (!this.#socket) return Promise.reject(new Error("not connected"));
    const id = ++this.#ids;
    this.#socket.send(JSON.stringify({ jsonrpc: "2.0", id, method, params }));
    return new Promise((resolve, reject) => this.#calls.set(id, { resolve, reject }));
  }

  // A request without an answer.
  notify(method) {
    this.#socket?.send(JSON.stringify({ jsonrpc: "2.0", method }));
  }

  #tell(type, detail) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  #take({ id, method, params, result, error }) {
    if (method) return this.#tell(method, params);
    const call = this.#calls.get(id);
    this.#calls.delete(id);
    if (error) call?.reject(new RpcError(error));
    else call?.resolve(result);
  }

  #lose(reason) {
    this.#socket = undefined;
    for (const { reject } of this.#calls.values()) reject(new Error("the connection ended"));
    this.#calls.clear();
    this.#tell("close", reason);
    setTimeout(() => this.connect(), this.#wait);
    this.#wait = Math.min(this.#wait * 2, 4000);
  }
}
