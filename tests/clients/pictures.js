// Quilts and an RGBD picture of plain colours, so that each view of a frame says which picture and which view of it it is.

import { deflateSync } from "node:zlib";

export const COLUMNS = 4, ROWS = 2, VIEWS = 8, WIDTH = 60, HEIGHT = 80;

// Each view has a colour of its own, which `red` makes that of one picture.
export const colour = (red, view) => [red, 30 + 20 * view, 220 - 20 * view];

// The checksum of PNG, which Node has since version 22.
const TABLE = Array.from({ length: 256 }, (_, n) => {
  for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
  return n >>> 0;
});
const crc32 = (bytes) => (bytes.reduce((crc, byte) => TABLE[(crc ^ byte) & 255] ^ (crc >>> 8), 0xffffffff) ^ 0xffffffff) >>> 0;

function png(width, height, at) {
  const raw = Buffer.alloc((3 * width + 1) * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) raw.set(at(x, y), (3 * width + 1) * y + 1 + 3 * x);
  const header = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 8, 2, 0, 0, 0]);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  const chunk = (type, data) => {
    const body = Buffer.concat([Buffer.from(type), data]), ends = Buffer.alloc(8);
    ends.writeUInt32BE(data.length, 0);
    ends.writeUInt32BE(crc32(body), 4);
    return Buffer.concat([ends.subarray(0, 4), body, ends.subarray(4)]);
  };
  const parts = [chunk("IHDR", header), chunk("IDAT", deflateSync(raw)), chunk("IEND", Buffer.alloc(0))];
  return Buffer.concat([Buffer.from("\x89PNG\r\n\x1a\n", "latin1"), ...parts]);
}
const viewAt = (x, y) => (ROWS - 1 - Math.floor(y / HEIGHT)) * COLUMNS + Math.floor(x / WIDTH);
export const quilt = (red) => png(COLUMNS * WIDTH, ROWS * HEIGHT, (x, y) => colour(red, viewAt(x, y)));
// One colour on a plane that leans a little, and its depth at the right.
export const rgbd = (red) => png(2 * WIDTH, HEIGHT, (x, y) => (x < WIDTH ? [red, 90, 40] : Array(3).fill(120 + Math.floor(y / 5))));

// A quilt without a file, as program.py reads it.
export function picture(red) {
  const pixels = Buffer.alloc(3 * COLUMNS * WIDTH * ROWS * HEIGHT);
  for (let i = 0; i < pixels.length / 3; i++)
    pixels.set(colour(red, viewAt(i % (COLUMNS * WIDTH), Math.floor(i / (COLUMNS * WIDTH)))), 3 * i);
  const size = { width: COLUMNS * WIDTH, height: ROWS * HEIGHT, columns: COLUMNS, rows: ROWS, aspect: WIDTH / HEIGHT };
  return JSON.stringify({ ...size, pixels: pixels.toString("hex") });
}
