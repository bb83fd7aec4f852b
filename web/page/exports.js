// The kinds of export that the page offers, and which parameters each has.

import { tidy } from "./numbers.js";

const PHOTO = ["photo", "photo_position"];
const STRIPES = ["dpi", "views", "stripes", "phase", "orientation", "bleed"];

export const EXPORTS = {
  still: {
    name: "Still",
    about: "the middle view as an image",
    endings: ["png", "jpg", "exr"],
    keys: ["denoise"],
  },
  quilt: {
    name: "Quilt",
    about: "all views as tiles of one image",
    endings: ["png", "jpg", "exr"],
    keys: ["denoise"],
  },
  panel: {
    name: "Panel",
    about: "the pixels of the panel",
    endings: ["png"],
    keys: ["filter", "invert", "gamma", "white", "white_x", "white_y", "denoise"],
  },
  rgbd: {
    name: "Colour and depth",
    about: "an image with its depth next to it",
    endings: ["png"],
    keys: ["side", "of", "depth_inversion", "near", "far"],
  },
  print: {
    name: "Print",
    about: "an image for a lenticular sheet, and its manifest",
    endings: ["tif"],
    needed: ["lpi", "width", "height"],
    keys: [
      ...STRIPES,
      "bits",
      "compress",
      "reverse",
      "mirror",
      "marks",
      ...PHOTO,
    ],
  },
  proof: {
    name: "Proof of a print",
    about: "what an eye sees of the print through its sheet",
    endings: ["png"],
    needed: ["lpi", "width", "height"],
    keys: [...STRIPES, "thickness", "distance", ...PHOTO],
  },
  chart: {
    name: "Pitch test chart",
    about: "stripes that show the pitch of a sheet",
    endings: ["tif"],
    needed: ["lpi", "width", "height", "range", "step"],
    keys: ["dpi", "orientation", "bits", "compress", "mirror"],
  },
};

/** What a parameter is called on the page. */
export const LABELS = {
  bits: "Bits per channel",
  bleed: "Bleed",
  compress: "Compression",
  denoise: "Denoise",
  depth_inversion: "Near is black",
  distance: "Viewing distance",
  dpi: "Printer resolution",
  far: "Farthest depth",
  filter: "Filter",
  gamma: "Response of the panel",
  height: "Height",
  invert: "Reverse the views",
  lpi: "Pitch of the lenses",
  marks: "Register marks",
  mirror: "Mirror",
  near: "Nearest depth",
  of: "Views",
  orientation: "Direction of lenses",
  phase: "Shift of the lenses",
  photo: "Photo",
  photo_position: "Place of the photo",
  range: "Range of pitches",
  reverse: "Reverse the views",
  side: "Side of the depth",
  step: "Step of pitches",
  stripes: "Stripes",
  thickness: "Thickness of the sheet",
  views: "Views under a lens",
  white: "White of the panel",
  white_x: "White, CIE x",
  white_y: "White, CIE y",
  width: "Width",
};

/** The kinds that the daemon knows too, in this order. */
export function kindsOf(parameters) {
  const known = parameters?.kind?.enum ?? [];
  return Object.keys(EXPORTS).filter((kind) => known.includes(kind));
}

/** The parameters of a kind that the daemon knows: [name, schema, needed]. @param photo one is shown */
export function parametersOf(kind, parameters, photo = false) {
  const { needed = [], keys } = EXPORTS[kind];
  return [...needed, ...keys]
    .filter((key) => parameters[key] && (photo || !PHOTO.includes(key)))
    .map((key) => [key, parameters[key], needed.includes(key)]);
}

// What a name says of its content. Programs read the tiles of a quilt from its name.
function suffixOf(kind, { columns, rows, aspect }) {
  if (kind === "quilt" && columns) return `_qs${columns}x${rows}a${tidy(aspect, 6)}`;
  return kind === "still" ? "" : `_${kind}`;
}

/** The name of the file for the call, after the scene. @param status result of the method status */
export function nameFor(kind, status, ending) {
  const name = (status.scene ?? "").split("/").pop();
  const base =
    name.replace(/(_qs\d+x\d+(a[\d.]+)?)?\.\w+$/, "").replace(/[^\w.-]+/g, "_") || "image";
  return `${base}${suffixOf(kind, status)}.${ending}`;
}

/** The value that a text or switch of the form stands for; undefined: left out. */
export function valueOf(schema, text) {
  if (typeof text === "boolean") return text === (schema.default ?? false) ? undefined : text;
  if (text.trim() === "") return undefined;
  const types = [schema.type].flat();
  const number = Number(text.replace(",", "."));
  if ((types.includes("number") || types.includes("integer")) && Number.isFinite(number))
    return number;
  return text.trim();
}

/** What the list of jobs says of a job. */
export function jobText(state, error, farm) {
  if (state === "failed") return error?.message ?? "failed";
  if (!farm || state !== "running") return state;
  const { complete, total } = farm.tasks;
  return `${farm.engine}: ${farm.state}${total > 0 ? `, ${complete} of ${total} tasks` : ""}`;
}
