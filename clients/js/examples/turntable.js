#!/usr/bin/env node
// Saves one quilt per direction, turn_0.jpg and so on: QUILTD_URL=URL turntable.js [NUMBER]
import { writeFile } from "node:fs/promises";
import { connect } from "../quiltd/node.js";

const number = Number(process.argv[2] ?? 8);
const q = await connect(process.env.QUILTD_URL);
for (let i = 0; i < number; i++) {
  await q.wait("complete", { timeout: 600 });
  await writeFile(`turn_${i}.jpg`, (await q.preview()).jpeg);
  await q.camera.orbit({ yaw: 360 / number });
}
q.close();
