// Pairs of views for two eyes.

export const MODES = {
  view: "One view",
  parallel: "Side by side",
  crossed: "Cross-eyed",
  anaglyph: "Red and cyan",
  quilt: "Quilt",
  panel: "Panel pixels",
};
export const STEREO = ["parallel", "crossed", "anaglyph"];

const EYES_DEGREES = 6;

/**
 * How many views the eyes are apart.
 * @param choice "eyes": about 6 degrees; else a number of views
 * @param cone view cone in degrees
 */
export function viewsApart(choice, views, cone) {
  const most = Math.max(views - 1, 0);
  const wanted =
    choice === "eyes" ? Math.round((EYES_DEGREES * views) / (cone || 40)) : Number(choice);
  return Math.min(Math.max(wanted, 1), most);
}

/** Where a position from 0 to 1 is among the views, from 0 to views - 1. */
export function viewAt(position, views) {
  return Math.min(Math.max(position * views - 0.5, 0), Math.max(views - 1, 0));
}

/** The views of the left and right eye around a position; at the ends the distance stays. */
export function pairAt(position, views, apart) {
  const last = Math.max(views - 1, 0);
  const left = Math.min(Math.max(position * views - 0.5 - apart / 2, 0), last - apart);
  return [left, left + apart];
}

// What the left eye gives to red: its brightness, so that colours do not fight between the eyes. The
// weights of each channel have the sum 1, so that grey stays grey.
export const RED_OF_LEFT = [0.299, 0.587, 0.114];

/** Colour of the red-cyan picture. @param left, right [r, g, b] */
export function anaglyph(left, right) {
  const red = left.reduce((sum, value, i) => sum + value * RED_OF_LEFT[i], 0);
  return [red, right[1], right[2]];
}
