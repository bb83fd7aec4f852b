// What the steps have: a quiltd on a simulated panel, a gateway before it with the services of other programs, pictures, and looks at
// what the panel shows. QUILTD_BUILD has our programs, CLIENTS_NODE the packages of others.

import { execFile, fork, spawn } from "node:child_process";
import { readFile, rm, writeFile } from "node:fs/promises";
import { connect as connectTcp } from "node:net";
import { join } from "node:path";
import { setTimeout as nap } from "node:timers/promises";
import { promisify } from "node:util";

import { start } from "../../clients/js/tests/live.js";
import { HEIGHT, WIDTH } from "./pictures.js";

const run = promisify(execFile);
const here = (name) => new URL(name, import.meta.url).pathname;
const built = (name) => join(process.env.QUILTD_BUILD, name);

export const PORTS = [33334, 9724, 11222];
const PATIENCE_MS = 1000 * Number(process.env.CLIENTS_PATIENCE ?? 60), LOOK_MS = 100;

// A panel whose picture a software renderer can draw. Real ones lack fringe and verticalAngle, too.
export const PANEL = {
  configVersion: "3.0", serial: "LKG-P00000", pitch: { value: 52.5 }, slope: { value: -7.25 }, center: { value: 0.25 },
  viewCone: { value: 40 }, invView: { value: 1 }, DPI: { value: 324 }, screenW: { value: 192 }, screenH: { value: 256 },
  flipImageX: { value: 0 }, flipImageY: { value: 0 }, flipSubp: { value: 0 },
};

// -------------------------------------------------------------------------------------------- programs --

async function ended(child) {
  if (child.exitCode !== null || child.signalCode !== null) return;
  const end = new Promise((resolve) => child.on("exit", resolve));
  child.kill();
  await end;
}

// A gateway with all services open: quiltweb, or the fake with a mistake. { text(), end() }
async function openServices(live, { fake, mistake, options = [], origin }) {
  const ipc = join(live.folder, "nng");
  await rm(ipc, { force: true });
  const command = fake
    ? ["python3", here("fake.py"), built("quiltctl"), live.socket, join(live.folder, "sim/calibration.json"), ipc, origin, ...(mistake ? [mistake] : [])]
    : [built("quiltweb"), "--socket", live.socket, "--listen", "127.0.0.1:0", "--bridge", "--webxr", `--nng=${ipc}`, "--allow-origin", origin, "--until-input-ends", ...options];
  const child = spawn(command[0], command.slice(1), { stdio: ["pipe", "pipe", "pipe"] });
  let log = "", said = "";
  child.stderr.on("data", (data) => (log += data));
  child.stdout.on("data", (data) => (said += data));
  while (!said.includes("\n")) {
    if (child.exitCode !== null) throw new Error(`the gateway ended: ${log}`);
    await nap(20);
  }
  return { ipc, log: () => log, end: () => ended(child), running: () => child.exitCode === null };
}

// A program of program.py. Fails with its reason.
export async function program(name, given = [], input = "") {
  const call = run("python3", [here("program.py"), name, ...given], { maxBuffer: 1 << 26, timeout: 2 * PATIENCE_MS });
  call.child.stdin.on("error", () => {}); // a program that stops reads no picture
  call.child.stdin.end(input);
  const { stdout } = await call.catch((error) => {
    throw new Error(error.stderr?.trim() || error.message);
  });
  return JSON.parse(stdout);
}

// A program with bridge.js: call("connect") and so on.
function startApp() {
  const child = fork(here("bridge_app.js"), [join(process.env.CLIENTS_NODE, "@lookingglass/bridge")], { stdio: ["ignore", "ignore", "ignore", "ipc"] });
  let settle; // of the call under way
  child.on("message", (answer) => settle(answer));
  child.on("exit", () => settle({ error: "the program with bridge.js ended" }));
  const next = () =>
    new Promise((resolve, reject) => {
      settle = ({ result, error }) => (error ? reject(new Error(error)) : resolve(result));
    });
  const ready = next();
  const call = async (name, ...given) => {
    await ready;
    const answer = next();
    child.send({ call: name, arguments: given });
    return answer;
  };
  return { call, end: () => ended(child) };
}

// ----------------------------------------------------------------------------------------------- world --

export function portIsTaken(port) {
  return new Promise((resolve) => {
    const socket = connectTcp(port, "localhost");
    socket.on("connect", () => socket.destroy() && resolve(true));
    socket.on("error", () => resolve(false));
  });
}

let patience = PATIENCE_MS;
// How long the steps wait for what must come; none: as long as usual.
export function setPatience(ms = PATIENCE_MS) {
  patience = ms;
}
// Until what() does not throw any more; its last reason is that of the failure.
export async function eventually(what) {
  for (const end = performance.now() + patience; ; await nap(LOOK_MS)) {
    try {
      return await what();
    } catch (error) {
      if (performance.now() > end) throw error;
    }
  }
}

export class World {
  static async make() {
    const files = { "sim/calibration.json": JSON.stringify(PANEL) };
    const options = ["--device", "sim:sim", "--view-size", `${WIDTH}x${HEIGHT}`, "--threads", "1", "--run-for", "1800"];
    const world = new World();
    world.live = await start({ options, files });
    return world;
  }

  async open(gateway) {
    this.services = await openServices(this.live, gateway);
    this.app = startApp();
  }
  async close() {
    await this.app.end();
    await this.services.end();
  }
  async end() {
    await this.live.stop();
  }

  async file(name, data) {
    const path = join(this.live.folder, name);
    await writeFile(path, data);
    return path;
  }

  async quiltctl(...words) {
    const { stdout } = await run(built("quiltctl"), ["--socket", this.live.socket, "--json", ...words]);
    return JSON.parse(stdout);
  }

  // The colour in the middle of a view, a quarter from the left, and so on.
  async look() {
    const file = join(this.live.folder, "frame.raw");
    await rm(file, { force: true });
    const info = await this.quiltctl("frame.get", file, "format=raw");
    const pixels = await readFile(file);
    const at = (view, across) => {
      const x = (view % info.columns) * info.width + Math.floor(across * info.width);
      const y = (info.rows - 1 - Math.floor(view / info.columns)) * info.height + Math.floor(info.height / 2);
      return [...pixels.subarray(3 * (y * info.columns * info.width + x)).subarray(0, 3)];
    };
    return { ...info, at };
  }
}
