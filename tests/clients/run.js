// The steps before quiltweb, or before the fake gateway: first as it should be, then with each of its mistakes, which some step has to
// find. Prints a line of TAP per step.
//
//   node run.js quiltweb | control     CLIENTS_BROWSER: "" or why there is none

import { execFileSync } from "node:child_process";

import { steps } from "./steps.js";
import { PORTS, World, portIsTaken, setPatience } from "./world.js";

// The mistakes of fake.py, and a step that must see each.
const SEEN_BY = {
  "shows nothing": "a quilt that bridge.js casts is on the panel",
  "no fringe": "bridge.js finds the panel and its calibration",
  "other serial": "VTK's module gets the numbers of its panel",
  "no error": "AliceLG's quilt is on the panel, though it reads no reply",
  "upside down": "the same over the WebSocket, with a reply that says so",
  "false success": "a program that looks at the reply sees Failure",
  "any origin": "a page of another origin reaches nothing",
  "other identifier": "nngcat gets the panel over the WebSocket",
};
const noBrowser = process.env.CLIENTS_BROWSER;
let number = 0;

function say(name, why, skipped) {
  console.log(`    ${why ? "not ok" : "ok"} ${++number} - ${name}${skipped ? ` # SKIP ${skipped}` : ""}`);
  if (why) console.log(why.replace(/^/gm, "      "));
}
const shortly = (error) => String(error?.message ?? error).split("\n").slice(0, 12).join("\n");

function missing({ needs }) {
  try {
    if (needs) execFileSync("which", [needs], { stdio: "ignore" });
    return "";
  } catch {
    return `there is no ${needs} (package nng-utils)`;
  }
}

async function runAll(world, list, prefix = "") {
  for (const step of list) {
    const skipped = missing(step);
    const before = world.services.log().length;
    const why = skipped ? "" : await step.run(world).then(() => "", shortly);
    say(prefix + step.name, why && `${why}\nlog of the gateway:\n${world.services.log().slice(before).slice(-2000)}`, skipped);
  }
}

async function before(world, gateway, act) {
  await world.open({ ...gateway, origin: world.origin });
  try {
    await act();
  } finally {
    await world.close();
  }
}

async function quiltweb(world, { browserSteps, panelOnlySteps }) {
  await before(world, {}, () => runAll(world, [...steps, ...browserSteps]));
  if (panelOnlySteps.length > 0) await before(world, { options: ["--panel-only"] }, () => runAll(world, panelOnlySteps));
}

async function control(world, { browserSteps }) {
  const all = [...steps, ...browserSteps];
  await before(world, { fake: true }, () => runAll(world, all, "fake: "));
  setPatience(5000); // what a wrong gateway does not do never comes
  for (const [mistake, name] of Object.entries(SEEN_BY)) {
    const last = all.findIndex((step) => step.name === name);
    if (last < 0) {
      say(`a gateway with the mistake "${mistake}" is found`, "", noBrowser);
      continue;
    }
    // what the step needs: a program that is connected, or a page that is open
    const wanted = all.slice(0, last + 1).filter((step, i) => i === last || /connects|finds the panel/.test(step.name));
    await before(world, { fake: true, mistake }, async () => {
      let found = "";
      for (const step of wanted) found = missing(step) ? "skip" : await step.run(world).then(() => "", shortly);
      say(`a gateway with the mistake "${mistake}" is found`, found ? "" : `"${name}" passed`, missing(all[last]));
    });
  }
}

const taken = [];
for (const port of PORTS) if (await portIsTaken(port)) taken.push(port);
if (taken.length > 0) {
  say("programs that people have", "", `port ${taken.join(" and ")} is in use by another program`);
  process.exit(0);
}
const inBrowser = noBrowser ? { browserSteps: [], panelOnlySteps: [] } : await import("./browser_steps.js");
if (noBrowser) say("pages in a browser", "", noBrowser);
const world = await World.make();
const servers = noBrowser ? [] : [await inBrowser.serve(), await inBrowser.serve()];
[world.origin, world.otherOrigin] = noBrowser ? ["http://localhost:1", "http://localhost:2"] : servers.map(({ origin }) => origin);
try {
  await (process.argv[2] === "control" ? control : quiltweb)(world, inBrowser);
} finally {
  await world.browser?.close();
  for (const server of servers) server.close();
  await world.end();
}
