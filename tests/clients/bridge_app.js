// A program with @lookingglass/bridge as it is published, in a process of its own. Its parent says which function to call:
// { call: "cast", arguments: [...] } gets { result } or { error }. argv[2]: the package's folder.

import { join } from "node:path";
import { pathToFileURL } from "node:url";

import { openWebSocket } from "../../clients/js/quiltd/websocket.js";

// What the package expects of a browser, and Node 20 lacks.
class NodeWebSocket {
  constructor(url) {
    openWebSocket(new URL(url.replace(/^ws/, "http")), {}).then(
      (socket) => {
        this.socket = socket;
        socket.received = (data) => this.onmessage?.({ data });
        socket.ended = () => this.onclose?.({});
        this.onopen?.({});
      },
      (error) => this.onerror?.(error),
    );
  }
  send(text) {
    this.socket.send(text);
  }
  close() {
    this.socket?.close();
  }
}
globalThis.window = globalThis;
globalThis.WebSocket ??= NodeWebSocket;

// package.json has the two kinds of module exchanged: by path
const { BridgeClient, QuiltHologram, RGBDHologram } = await import(pathToFileURL(join(process.argv[2], "dist/looking-glass-bridge.mjs")));
const client = BridgeClient.getInstance();
client.setVerbosity(0);
const events = [];

const calls = {
  quilt: (uri, settings) => client.cast(new QuiltHologram({ uri, settings })),
  rgbd: (uri, settings) => client.cast(new RGBDHologram({ uri, settings })),
  listen: (name) => client.addEventListener(name, () => events.push(name)),
  events: () => events,
  update: (parameter, value) => client.updateCurrentHologram({ name: client.getCurrentPlaylist().name, parameter, value }),
};

process.on("message", async ({ call, arguments: given }) => {
  try {
    process.send({ result: await (calls[call] ?? client[call].bind(client))(...given) });
  } catch (error) {
    process.send({ error: String(error) });
  }
});
process.on("disconnect", () => process.exit());
process.send({ result: "ready" });
