// The camera as vectors: see Camera in docs/reference/scene-format.md.

const sub = (a, b) => a.map((x, i) => x - b[i]);
const along = (a, b, t) => a.map((x, i) => x + b[i] * t);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const length = (a) => Math.hypot(...a);
const unit = (a) => a.map((x) => x / length(a));
const isPoint = (value) => Array.isArray(value) && value.length === 3;

const usual = { target: [0, 0, 0], position: [0, 0, 5], up: [0, 1, 0], fov_y: 14 };

/** The camera with the usual values; undefined if keyframes or a file place it. */
export function placed(camera) {
  const all = { ...usual, ...camera };
  const own = isPoint(all.position) && isPoint(all.target) && isPoint(all.up);
  return own && !camera?.from ? all : undefined;
}

export function distanceOf({ position, target }) {
  return length(sub(target, position));
}

/**
 * The target at another distance along the line of sight. The middle camera and its angle stay, so
 * the middle view stays as it is; the focal plane moves through the scene, and what was in it shifts
 * from view to view.
 */
export function targetAt({ position, target }, distance) {
  return along(position, unit(sub(target, position)), distance);
}

/** Position and target after the image has moved by pixels of a window of some height. */
export function shifted({ position, target, up, fov_y }, right, down, height) {
  const sight = sub(target, position);
  const across = unit(cross(sight, up)),
    upwards = unit(cross(across, sight));
  const perPixel = (2 * length(sight) * Math.tan((fov_y * Math.PI) / 360)) / height;
  const moved = (point) => along(along(point, across, -right * perPixel), upwards, down * perPixel);
  return { position: moved(position), target: moved(target) };
}
