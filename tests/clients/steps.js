// The steps of the test: what a program asks for, and what has to come of it. Each is { name, run(world) }; they run in this order,
// on one panel. `needs`: a program that has to be there.

import assert from "node:assert/strict";

import { COLUMNS, VIEWS, colour, picture, quilt, rgbd } from "./pictures.js";
import { PANEL, eventually, program } from "./world.js";

export const steps = [];
const step = (name, run, needs) => steps.push({ name, run, needs });

const SETTINGS = { rows: 2, columns: COLUMNS, aspect: 0.75, viewCount: VIEWS };
const NUMBERS = Object.entries(PANEL).filter(([, value]) => typeof value === "object").map(([name, { value }]) => [name, value]);
const RED = { first: 200, second: 150, third: 100, fourth: 50, fifth: 250 };

async function shows(world, red) {
  await eventually(async () => {
    const { at, views } = await world.look();
    assert.equal(views, VIEWS, "views on the panel");
    for (let view = 0; view < VIEWS; view++) assert.deepEqual(at(view, 0.5), colour(red, view), `colour of view ${view}`);
  });
}
const cast = async (world, name) => world.app.call("quilt", await world.file(`${name}.png`, quilt(RED[name])), SETTINGS);
const succeeds = (answer) => assert.equal(answer.success, true, JSON.stringify(answer));

// What the gateway's log gets for a request that cannot be done. The panel keeps the picture.
async function failsInTheLog(world, word, act) {
  const before = world.services.log().length;
  await act();
  await eventually(() => assert.match(world.services.log().slice(before), word));
}

// --------------------------------------------------------------------------- bridge.js as it is published --

step("bridge.js sees that Bridge is there", async ({ app }) => assert.equal(await app.call("status"), true));
step("bridge.js connects", async ({ app }) => {
  const answer = await app.call("connect");
  succeeds(answer);
  assert.equal(answer.response.version.major, 2);
});
step("bridge.js finds the panel and its calibration", async ({ app }) => {
  const { success, response } = await app.call("getDisplays");
  assert.equal(success, true);
  assert.equal(response.length, 1, "displays");
  const { calibration, defaultQuilt } = response[0];
  assert.equal(calibration.serial, PANEL.serial);
  for (const [name, value] of NUMBERS) assert.equal(calibration[name], value, name);
  assert.ok(defaultQuilt.columns > 1 && defaultQuilt.rows > 1, JSON.stringify(defaultQuilt));
});
step("a quilt that bridge.js casts is on the panel", async (world) => {
  succeeds(await cast(world, "first"));
  await shows(world, RED.first);
});
step("a second cast replaces the first", async (world) => {
  succeeds(await cast(world, "second"));
  await shows(world, RED.second);
});
step("bridge.js changes the focus and back", async (world) => {
  succeeds(await world.app.call("update", "focus", 0.02));
  succeeds(await world.app.call("update", "focus", 0));
  await shows(world, RED.second);
});
step("bridge.js pauses, plays and seeks", async ({ app }) => {
  for (const call of ["pause", "play", "next", "previous"]) succeeds(await app.call(call));
  succeeds(await app.call("seek", 0));
  succeeds(await app.call("showWindow", true));
  succeeds(await app.call("apiVersion"));
});
step("an RGBD picture that bridge.js casts becomes views", async (world) => {
  const settings = { depthiness: 1, focus: 0, aspect: 0.75, chroma_depth: 0, depth_inversion: 0, depth_loc: 2, zoom: 1 };
  succeeds(await world.app.call("rgbd", await world.file("depth.png", rgbd(RED.third)), settings));
  await eventually(async () => {
    const { at, views } = await world.look();
    assert.ok(views > 1, `${views} views`);
    for (const view of [0, views - 1])
      for (const across of [0.3, 0.5, 0.7])
        at(view, across).forEach((got, i) => assert.ok(Math.abs(got - [RED.third, 90, 40][i]) < 4, `view ${view}: ${at(view, across)}`));
  });
});
step("a cast of a missing file fails in the log, and the picture stays", async (world) => {
  succeeds(await cast(world, "first"));
  await shows(world, RED.first);
  await failsInTheLog(world, /gone\.png/, () => world.app.call("quilt", "/nowhere/gone.png", SETTINGS));
  await shows(world, RED.first);
});
step("a cast of a URL fails in the log, and the picture stays", async (world) => {
  await failsInTheLog(world, /https|network/, () => world.app.call("quilt", "https://example.com/a_qs4x2a0.75.png", SETTINGS));
  await shows(world, RED.first);
});
step("a program that looks at the reply sees Failure", async () => {
  const token = (await program("ask", ["enter_orchestration", '{"name": "default"}'])).payload.value;
  const say = (endpoint, more) => program("ask", [endpoint, JSON.stringify({ orchestration: token, name: "gone", ...more })]);
  await say("instance_playlist", { loop: true });
  const statuses = [
    await say("insert_playlist_entry", { index: 0, uri: "/nowhere/gone.png", rows: 2, cols: 4, aspect: 0.75, view_count: 8, isRGBD: 0 }),
    await say("play_playlist", { head_index: -1 }),
  ].map(({ status }) => status.value);
  assert.ok(statuses.includes("Failure"), `statuses: ${statuses}`);
  await say("delete_playlist", { loop: true });
});
step("bridge.js disconnects", async ({ app }) => succeeds(await app.call("disconnect")));

// --------------------------------------------------------------------------- other programs with Bridge's API --

step("bridge.js of its repository plays a list, and steps through it", async (world) => {
  const files = [await world.file("first.png", quilt(RED.first)), await world.file("second.png", quilt(RED.second))];
  const { orchestration } = await program("newest", files);
  const control = (name, more) => program("ask", [`transport_control_${name}`, JSON.stringify({ orchestration, ...more })]);
  await shows(world, RED.first);
  await control("next");
  await shows(world, RED.second);
  await control("previous");
  await shows(world, RED.first);
  await control("seek_to_index", { index: 1 });
  await shows(world, RED.second);
});
step("quiltwright --cast shows its quilt, pauses and goes on", async (world) => {
  await program("quiltwright", [await world.file("third.png", quilt(RED.third))]);
  await shows(world, RED.third);
  await program("pause");
  assert.equal((await world.quiltctl("playlist.get")).paused, true);
  await program("resume");
  assert.equal((await world.quiltctl("playlist.get")).paused, false);
  await shows(world, RED.third);
});

// ----------------------------------------------------------------------------------------- the older service --

function isOurs(device) {
  assert.equal(device.hwid, PANEL.serial);
  assert.equal(device.state, "ok");
  for (const [name, value] of NUMBERS) assert.equal(device.calibration[name].value, value, name);
  for (const name of ["tileX", "tileY", "quiltX", "quiltY"]) assert.ok(device.defaultQuilt[name] > 1, name);
}
step("the bare WebSocket says the calibration", async () => {
  const said = await program("text");
  assert.equal(said.serial, PANEL.serial);
  for (const [name, value] of NUMBERS) assert.equal(said[name].value, value, name);
});
step("nngcat gets the panel over the WebSocket", async () => {
  const reply = await program("nngcat", ["ws://127.0.0.1:11222/driver"]);
  assert.equal(reply.error, 0);
  isOurs(reply.devices[0]);
}, "nngcat");
step("nngcat gets the panel over the Unix socket", async ({ services }) => {
  const reply = await program("nngcat", [`ipc://${services.ipc}`]);
  assert.equal(reply.error, 0);
  isOurs(reply.devices[0]);
}, "nngcat");
step("VTK's module gets the numbers of its panel", async ({ services }) => {
  const { device, numbers } = await program("vtk", [services.ipc]);
  isOurs(device);
  for (const [name, value] of NUMBERS) assert.equal(numbers[name], value, name);
});
step("AliceLG's quilt is on the panel, though it reads no reply", async (world) => {
  const { device, after } = await program("alice", [world.services.ipc], picture(RED.fourth));
  isOurs(device);
  assert.equal(after, 0);
  await shows(world, RED.fourth);
});
step("the same over the WebSocket, with a reply that says so", async (world) => {
  assert.equal((await program("bindata", ["ws"], picture(RED.fifth))).error, 0);
  await shows(world, RED.fifth);
});
step("show without a picture, hide and wipe are answered", async ({ services }) => {
  for (const reply of await program("demo", [services.ipc])) assert.equal(reply.error, 0);
});
