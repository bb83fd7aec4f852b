#!/usr/bin/env node
// A slider for the vertical angle of the camera: each line that you type is an angle in degrees.
import { createInterface } from "node:readline";
import { connect } from "../quiltd/node.js";

const q = await connect(process.env.QUILTD_URL);
for await (const line of createInterface({ input: process.stdin })) {
  await q.camera.set({ fov_y: Number(line) });
  console.log("shown:", (await q.wait("complete", { timeout: 60 })).level);
}
q.close();
