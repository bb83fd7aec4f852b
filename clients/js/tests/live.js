// A quiltd of the tests' own on a simulated panel, and a quiltweb before it. QUILTD_BUILD has their programs.

import { spawn } from "node:child_process";
import { mkdir, mkdtemp, rm, writeFile } from "node:fs/promises";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { setTimeout as nap } from "node:timers/promises";

import { connect } from "../quiltd/node.js";

export const VIEWS = 6, WIDTH = 24, HEIGHT = 32;
const SCENE = {
  quiltd: 1,
  camera: { views: VIEWS, cone: 30 },
  volumes: { fog: { shape: "sphere", density: 4, albedo: 0.9 } },
  lights: { sky: { type: "environment", radiance: 0.7 } },
};

// The first line that a program prints on this stream.
function firstLine(stream) {
  return new Promise((resolve, reject) => {
    let text = "";
    stream.on("data", (data) => {
      text += data;
      if (text.includes("\n")) resolve(text.slice(0, text.indexOf("\n")));
    });
    stream.on("end", () => reject(new Error(`the program ended: ${text}`)));
  });
}

// Another quiltweb before the same quiltd: { quiltweb, url }. Its caller ends it.
export async function startGateway(socket, listen = "127.0.0.1:0", ...options) {
  const quiltweb = spawn(join(process.env.QUILTD_BUILD, "quiltweb"), ["--socket", socket, "--listen", listen, ...options], {
    stdio: ["ignore", "pipe", "ignore"],
  });
  return { quiltweb, url: (await firstLine(quiltweb.stdout)).trim() };
}

// A port on which nobody listens now.
export async function freePort() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const { port } = server.address();
  await new Promise((resolve) => server.close(resolve));
  return port;
}

async function ended(child) {
  if (child.exitCode !== null || child.signalCode !== null) return;
  const end = new Promise((resolve) => child.on("exit", resolve));
  child.kill();
  await end;
}

const OPTIONS = ["--device", "sim:panel", "--view-size", `${WIDTH}x${HEIGHT}`, "--threads", "1", "--run-for", "1800"];

// { folder, scene, socket, url, q, pids, stop() }; q is a client over the socket, closed by stop().
// files: more of them in the folder, by name. scene: a file, instead of a document. web: of the folder, more options of quiltweb.
export async function start({ document = SCENE, options = OPTIONS, files = {}, scene, web = () => [] } = {}) {
  const build = process.env.QUILTD_BUILD;
  const folder = await mkdtemp(join(tmpdir(), "quiltd-js-"));
  const socket = join(folder, "s");
  if (!scene) await writeFile((scene = join(folder, "scene.json")), JSON.stringify(document));
  for (const [name, data] of Object.entries(files)) {
    await mkdir(dirname(join(folder, name)), { recursive: true });
    await writeFile(join(folder, name), data);
  }
  const quiltd = spawn(join(build, "quiltd"), [scene, "--socket", socket, ...options], { cwd: folder, stdio: "ignore" });
  let q;
  while (!q) {
    q = await connect(socket).catch(() => nap(50));
    if (quiltd.exitCode !== null) throw new Error("quiltd ended");
  }
  const { quiltweb, url } = await startGateway(socket, "127.0.0.1:0", ...(await web(folder)));
  const stop = async () => {
    q.close();
    await ended(quiltweb);
    await ended(quiltd);
    await rm(folder, { recursive: true });
  };
  return { folder, scene, socket, url, q, pids: { quiltd: quiltd.pid, quiltweb: quiltweb.pid }, stop };
}
