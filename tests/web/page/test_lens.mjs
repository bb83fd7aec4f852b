// The lens of a panel: the vectors of tests/quilt/test_interlace.c.
import assert from "node:assert/strict";
import { test } from "node:test";
import { lensOf, shareOf, viewOfSubpixel } from "../../../web/page/lens.js";

const panel = (pitch, slope, center, DPI, screenW, screenH, more) => ({
  configVersion: "3.0",
  pitch,
  slope,
  center,
  DPI,
  screenW,
  screenH,
  invView: 1,
  flipImageX: 0,
  flipSubp: 0,
  CellPatternMode: 0,
  subpixelCells: [],
  ...more,
});
const cell = (r, g, b) => ({
  ROffsetX: r[0],
  ROffsetY: r[1],
  GOffsetX: g[0],
  GOffsetY: g[1],
  BOffsetX: b[0],
  BOffsetY: b[1],
});
const portrait = panel(52.594383239746094, -7.21152925491333, 0.40277382731437683, 324, 1536, 2048);
const known = [
  [
    panel(47.56401443481445, -5.480000019073486, 0.374184787273407, 338, 2560, 1600),
    45,
    [
      [14, 12, 10],
      [23, 21, 19],
      [20, 18, 16],
    ],
  ],
  [
    portrait,
    48,
    [
      [16, 13, 10],
      [34, 31, 29],
      [7, 5, 2],
    ],
  ],
  [
    panel(80.74475016919882, -6.6587766801719095, 0.47708486403293315, 491, 1440, 2560),
    66,
    [
      [26, 23, 19],
      [1, 64, 60],
      [58, 54, 51],
    ],
  ],
  [
    panel(44.72, -7.45, 0, 283, 2160, 3840, {
      CellPatternMode: 4,
      subpixelCells: [
        cell([-0.25, -0.31], [-0.25, 0.28], [0.25, 0]),
        cell([0.25, -0.31], [0.25, 0.28], [-0.25, 0]),
      ],
    }),
    66,
    [
      [63, 64, 58],
      [33, 34, 28],
      [30, 30, 35],
    ],
  ],
  [
    panel(44.72, -6.9, 0.5, 283, 3840, 2160, {
      CellPatternMode: 2,
      subpixelCells: [
        cell([-0.31, 0.25], [0.28, 0.25], [0, -0.25]),
        cell([-0.31, -0.25], [0.28, -0.25], [0, 0.25]),
      ],
    }),
    49,
    [
      [23, 19, 20],
      [18, 14, 15],
      [1, 46, 0],
    ],
  ],
];
const rgb = (lens, n, x, y) => [0, 1, 2].map((c) => viewOfSubpixel(lens, n, x, y, c));

test("known subpixels show the known views", () => {
  for (const [calibration, n, views] of known) {
    const lens = lensOf(calibration);
    const at = [
      [0, 0],
      [100, 200],
      [calibration.screenW - 1, calibration.screenH - 1],
    ];
    assert.deepEqual(
      at.map(([x, y]) => rgb(lens, n, x, y)),
      views,
    );
  }
});

test("the patterns of cells are those of the panels", () => {
  const cells = [0, 1, 2, 3].map((i) => cell([i, 0], [i, 0], [i, 0]));
  const plain = {
    ...portrait,
    pitch: 1,
    DPI: 1536,
    slope: 1e12,
    center: 0,
    configVersion: "1.0",
    invView: 0,
  };
  // one lens over the whole panel and as many views as columns: the view is the column of the cell
  const column = (mode, x, y) =>
    viewOfSubpixel(
      lensOf({ ...plain, CellPatternMode: mode, subpixelCells: cells }),
      1536,
      x,
      y,
      0,
    ) - x;
  const rows = (mode) => [0, 1, 2, 3].map((y) => [0, 1].map((x) => column(mode, 100 + x, y)));
  assert.deepEqual(rows(0), [
    [0, 0],
    [0, 0],
    [0, 0],
    [0, 0],
  ]);
  assert.deepEqual(rows(1), [
    [0, 1],
    [1, 0],
    [0, 1],
    [1, 0],
  ]);
  assert.deepEqual(rows(2), [
    [0, 1],
    [0, 1],
    [0, 1],
    [0, 1],
  ]);
  assert.deepEqual(rows(3), [
    [0, 2],
    [1, 3],
    [2, 0],
    [3, 1],
  ]);
  assert.deepEqual(rows(4), [
    [0, 0],
    [1, 1],
    [0, 0],
    [1, 1],
  ]);
});

test("flipSubp swaps red and blue, and flipImageX the direction of the stripes", () => {
  const [r, g, b] = rgb(lensOf(portrait), 48, 0, 0);
  assert.deepEqual(rgb(lensOf({ ...portrait, flipSubp: 1 }), 48, 0, 0), [b, g, r]);
  const mirrored = lensOf({ ...portrait, flipImageX: 1 });
  assert.equal(mirrored.subpixel, -lensOf(portrait).subpixel);
  assert.equal(mirrored.tilt, -lensOf(portrait).tilt);
});

test("invView counts only for the first generation", () => {
  const from = (more) => lensOf({ ...portrait, ...more }).fromRight;
  assert.equal(from({ configVersion: "1.0", invView: 0 }), false);
  assert.equal(from({ configVersion: "1.0", invView: 1 }), true);
  assert.equal(from({ configVersion: "3.0", invView: 0 }), true);
});

test("views of another shape have borders", () => {
  const lens = lensOf(portrait);
  assert.deepEqual(shareOf(lens, 0.75), [1, 1]);
  assert.deepEqual(shareOf(lens, 0.7504), [1, 1]);
  assert.deepEqual(shareOf(lens, 1.5), [1, 0.5]);
  assert.deepEqual(shareOf(lens, 0.375), [0.5, 1]);
});
