// What the types promise, as users write it. tsc reads it, nobody runs it.
import { QuiltdError, connect } from "quiltd";

const q = await connect("http://127.0.0.1:8033/#0");
const { generation } = await q.camera.orbit({ yaw: 15 });
generation satisfies number | undefined;
await q.render.set({ denoise: "off", exposure: 1 });
await q.render.set({ exposure: "scene" });
(await q.call("status")).state satisfies string | undefined;
await q.call("a method of a later quiltd", { any: 1 });
await q.wait("complete", { timeout: 60 });
for await (const { name, params } of q.events("frame", "scene", { timeout: 10 }))
  if (name === "frame") params.level satisfies string | undefined;
for await (const image of q.images()) image.jpeg satisfies Uint8Array;
const { path } = await q.upload("helmet.glb", new Uint8Array());
await q.scene.load({ file: path, files: [path] });
const [{ data }] = await q.export("still", { wait: "complete" });
data satisfies Uint8Array;
if (new Error() instanceof QuiltdError) q.close();

// @ts-expect-error an unknown parameter
await q.camera.orbit({ jaw: 15 });
// @ts-expect-error a wrong type
await q.camera.orbit({ yaw: "15" });
// @ts-expect-error an unknown word
await q.wait("done");
// @ts-expect-error an unknown event
q.events("frames");
// @ts-expect-error a parameter that is required is missing
await q.job.cancel({});
// @ts-expect-error an unknown method
await q.camera.turn({});
