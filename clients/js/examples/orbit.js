#!/usr/bin/env node
// Turns the camera once around its target: orbit.js [DEGREES PER STEP]
import { connect } from "../quiltd/node.js";

const step = Number(process.argv[2] ?? 10);
const q = await connect(process.env.QUILTD_URL);
for (let i = 0; i < Math.round(360 / step); i++) {
  await q.camera.orbit({ yaw: step });
  console.log("generation", (await q.wait("coarse", { timeout: 60 })).generation);
}
q.close();
