// What a file is by its name, and what quiltd is to do with it.

const KINDS = [
  ["model", /\.(glb|gltf|obj|ply|stl|3ds)$/i],
  ["volume", /\.vdb$/i],
  ["environment", /\.(hdr|exr)$/i],
  ["scene", /\.json$/i],
  ["image", /\.(png|jpe?g)$/i],
];
const QUILT = /_qs(\d+)x(\d+)(?:a[\d.]+)?\.\w+$/i;

/** model, volume, environment, scene, quilt, image or undefined: a file that belongs to another. */
export function kindOf(name) {
  if (QUILT.test(name) && !/\.json$/i.test(name)) return "quilt";
  return KINDS.find(([, ending]) => ending.test(name))?.[0];
}

/** The file that the others belong to: a scene, else a model, and so on. */
export function mainOf(names) {
  const order = ["scene", "model", "volume", "quilt", "environment", "image"];
  const rank = (name) => order.indexOf(kindOf(name));
  return names.filter(kindOf).sort((a, b) => rank(a) - rank(b))[0];
}

/** "8 x 6", "8x6" or "8 6" as "8x6"; undefined: neither. */
export function tilesOf(text) {
  const [, columns, rows] = /^\s*(\d{1,3})\s*[x×* ]\s*(\d{1,3})\s*$/i.exec(text) ?? [];
  return columns > 0 && rows > 0 ? `${Number(columns)}x${Number(rows)}` : undefined;
}

/** A path without leading slashes and steps out of its folder. */
export function safePath(path) {
  return path
    .split("/")
    .filter((part) => part && part !== "." && part !== "..")
    .join("/");
}

/** The patch that makes a picture the only environment of a scene. */
export function environmentPatch(scene, file) {
  const patch = {};
  for (const [name, light] of Object.entries(scene?.lights ?? {}))
    if (["environment", "sky", "studio"].includes(light.type)) patch[name] = null;
  const kept = Object.keys(scene?.lights ?? {}).find(
    (name) => scene.lights[name].type === "environment",
  );
  const name = kept ?? "environment";
  patch[name] = {
    type: "environment",
    file,
    ...leftOut(scene?.lights?.[name], ["type", "file", "scale", "rotate", "visible"]),
  };
  return { lights: patch, ...(scene?.backdrop === undefined ? {} : { backdrop: null }) };
}

function leftOut(object, kept) {
  return Object.fromEntries(
    Object.keys(object ?? {})
      .filter((key) => !kept.includes(key))
      .map((key) => [key, null]),
  );
}
