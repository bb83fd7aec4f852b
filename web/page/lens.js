// The lens of a panel: which view each subpixel shows. The same formulas, in the same order, as
// quilt/panel/interlace.c.

const SAME_ASPECT = 1e-3;

// The vendor's software reads invView only for the first generation.
const countsFromRight = (c) => c.configVersion !== "1.0" || Boolean(c.invView);

/**
 * The numbers that the formulas derive from a calibration.
 * @param c result of device.calibration
 */
export function lensOf(c) {
  const mirrored = c.flipImageX ? -1 : 1;
  return {
    width: c.screenW,
    height: c.screenH,
    pitch: ((c.pitch * c.screenW) / c.DPI) * Math.cos(Math.atan(1 / c.slope)),
    tilt: (mirrored * c.screenH) / (c.screenW * c.slope),
    center: c.center,
    subpixel: mirrored / (3 * c.screenW),
    fromRight: countsFromRight(c),
    red: c.flipSubp ? 2 : 0,
    pattern: c.CellPatternMode ?? 0,
    cells: (c.subpixelCells ?? []).map((cell) => [
      [cell.ROffsetX, cell.ROffsetY],
      [cell.GOffsetX, cell.GOffsetY],
      [cell.BOffsetX, cell.BOffsetY],
    ]),
  };
}

function cellOf({ pattern, cells }, x, y) {
  const of = [0, (x + y) & 1, x % 2, (y + 2 * (x % 2)) % 4, y % 2][pattern] ?? 0;
  return cells.length ? of % cells.length : 0;
}

// Position across the cone, 0 to 1, for a phase in lens periods.
function placeOf(phase, fromRight) {
  const f = phase - Math.floor(phase);
  return Math.min(Math.max(fromRight ? 1 - f : f, 1e-5), 0.999999);
}

/** The view of channel c (0 red, 1 green, 2 blue) of the pixel x from the left, y from the bottom. */
export function viewOfSubpixel(lens, views, x, y, c) {
  const cell = lens.cells[cellOf(lens, x, y)];
  const stripe = c === 1 ? 1 : c === 0 ? lens.red : 2 - lens.red;
  const u = (x + 0.5) / lens.width + (cell ? cell[c][0] / lens.width : stripe * lens.subpixel);
  const v = (y + 0.5) / lens.height + (cell ? cell[c][1] / lens.height : 0);
  const phase = (u + v * lens.tilt) * lens.pitch - lens.center;
  return Math.floor(placeOf(phase, lens.fromRight) * views);
}

/** The shares of the panel's width and height that views of this aspect cover; the rest is black. */
export function shareOf({ width, height }, aspect) {
  let ratio = aspect > 0 ? (aspect * height) / width : 1;
  if (Math.abs(ratio - 1) < SAME_ASPECT) ratio = 1;
  return [Math.min(ratio, 1), Math.min(1 / ratio, 1)];
}
