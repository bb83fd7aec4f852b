// What a file is by its name, and what quiltd is to do with it.

const KINDS = [
  ["model", /\.(glb|gltf|obj|ply|stl|3ds)$/i],
  ["volume", /\.vdb$/i],
  ["environment", /\.(hdr|exr)$/i],
  ["scene", /\.json$/i],
  ["video", /\.(mp4|m4v|mov|webm|mkv|avi|gif)$/i],
  ["image", /\.(png|jpe?g)$/i],
];
const RGBD = /_rgbd\.\w+$/i;
const QUILT = /_qs(\d+)x(\d+)(?:a[\d.]+)?\.\w+$/i;

/** model, volume, environment, scene, quilt, video, image or undefined: a file that belongs to another. */
export function kindOf(name) {
  const kind = KINDS.find(([, ending]) => ending.test(name))?.[0];
  return QUILT.test(name) && kind !== "scene" && kind !== "video" ? "quilt" : kind;
}

/** Whether a name says what is in a picture or video: tiles, or depth at its right. */
export const saysAll = (name) => QUILT.test(name) || RGBD.test(name);

/** The file that the others belong to: a scene, else a model, and so on. */
export function mainOf(names) {
  const order = ["scene", "model", "volume", "quilt", "video", "environment", "image"];
  const rank = (name) => order.indexOf(kindOf(name));
  return names.filter(kindOf).sort((a, b) => rank(a) - rank(b))[0];
}

const NAMING = /\.(glb|gltf|obj|mtl|ply|3ds|json)$/i;
const NAMED = /\.(png|jpe?g|tga|bmp|webp|hdr|exr|mtl|bin)$/i;

/** Whether a file of this name may name others in its text. */
export const mayName = (name) => NAMING.test(name);

// Of these, quiltd shows one at a time.
const ALIKE = [
  ["model", "volume"],
  ["quilt", "image", "environment"],
];

/**
 * What a person should know about files that are sent together.
 * @param main the one that is shown
 * @param texts contents, in lower case, of those that mayName says; undefined: not known
 * @returns sentences
 */
export function notesOn(names, main, texts) {
  const notes = [];
  const kinds = ALIKE.find((some) => some.includes(kindOf(main))) ?? [];
  const alike = names.filter((name) => kinds.includes(kindOf(name)));
  if (alike.length > 1)
    notes.push(`Of ${alike.length} files only ${main} is shown.`);
  if (texts && ["model", "scene"].includes(kindOf(main)))
    for (const name of names.filter((one) => one !== main && isLost(one, texts)))
      notes.push(`${name} is not used: no other file names it.`);
  return notes;
}

function isLost(path, texts) {
  const name = path.split("/").pop().toLowerCase();
  const said = [name, encodeURI(name).toLowerCase()];
  return NAMED.test(name) && !texts.some((text) => said.some((one) => text.includes(one)));
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
