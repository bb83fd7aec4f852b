// Numbers of the daemon in words.

/** "1 entry", "3 entries". */
export const count = (n, noun, plural = `${noun}s`) => `${n} ${n === 1 ? noun : plural}`;

const MINUTES = [1, 2, 3, 5, 10, 15, 20, 30, 45, 60];

/** "less than a minute", "about 10 min", "hours": no rounder than an estimate is. */
export function duration(seconds) {
  if (seconds < 45) return "less than a minute";
  if (seconds >= 5400) return "hours";
  const minutes = seconds / 60;
  const off = (n) => Math.abs(Math.log(minutes / n));
  return `about ${MINUTES.reduce((a, b) => (off(b) < off(a) ? b : a))} min`;
}

/**
 * Seconds until the target is met: as the daemon says, else by the error, which falls as 1 / passes.
 * Undefined: unknown.
 */
export function secondsLeft(status) {
  if (status.seconds_left !== undefined) return status.seconds_left ?? undefined;
  const error = status.error_bound ?? status.error_estimate;
  if (!(error > 0) || !(status.target_error > 0) || !(status.seconds > 0)) return undefined;
  return Math.max(0, status.seconds * (error / status.target_error - 1));
}

export const fileName = (path) => path?.split("/").pop() ?? "";

// What there is of the image: its level, or why there is none.
function levelText(status) {
  if (status.load?.file && status.load.kind === "file")
    return `loading ${fileName(status.load.file)}`;
  if (status.level !== "none") return status.level;
  if (status.paused) return "Paused: press Pause to see the change";
  return status.scene ? "waiting for the first image" : "no scene";
}

// How far a video is.
function videoText({ seconds, duration, frame, paused, problem }) {
  const length = duration ? ` of ${duration.toFixed(1)}` : "";
  const state = problem ? ["stopped"] : paused ? ["paused"] : [];
  return ["video", `${seconds.toFixed(1)}${length} s`, `frame ${frame}`, ...state].join(" · ");
}

/**
 * A line on how far the image is.
 * @param status result of the method status
 * @param left words on the time left
 * @param waits the picture is still that of another scene
 */
export function describe(status, left, waits) {
  if (status.is_quilt && waits) return "waiting for the first image";
  if (status.video) return `${videoText(status.video)} · ${count(status.views, "view")}`;
  if (status.is_quilt) return `finished image · ${count(status.views, "view")}`;
  const level = levelText(status);
  if (status.level === "none") return level;
  const words = status.state === "rendering" ? [level, left] : [status.state, level];
  if (status.passes != null) words.push(`${status.passes.toPrecision(3)} passes`);
  return [...new Set(words.filter(Boolean))].join(" · ");
}

/** How far an error has come from 1 to the target, by its logarithm: 0 to 1. */
export function progressOf(error, target) {
  if (!(error > 0) || !(target > 0)) return 0;
  return Math.min(Math.max(Math.log(error) / Math.log(Math.min(target, 0.5)), 0), 1);
}

export function errorText(error) {
  return error == null ? "unknown" : error.toPrecision(2);
}

export function bytesText(bytes) {
  if (bytes < 1000) return `${bytes} bytes`;
  const units = ["kB", "MB", "GB"];
  let value = bytes / 1000,
    i = 0;
  for (; value >= 1000 && i < 2; i++) value /= 1000;
  return `${value < 10 ? value.toFixed(1) : Math.round(value)} ${units[i]}`;
}

const HARDWARE = /^(udev|udev rule|USB|displays|panels|calibrations): /;

/**
 * The findings of doctor in two lists: what is shown, and notes about hardware that a simulated panel
 * does not need.
 * @param kind device.kind of the status
 */
export function sortFindings(findings, kind) {
  const aside = ({ level, text }) => kind === "sim" && level === "note" && HARDWARE.test(text);
  return { shown: findings.filter((one) => !aside(one)), folded: findings.filter(aside) };
}

/** What status.depth_budget means, and what to do. @returns {text, level: "ok" | "note" | "fail"} */
export function depthText(budget) {
  if (!budget) return { level: "note", text: "The depth of this image is unknown." };
  const behind = budget.farthest_step > budget.limit;
  const front = budget.nearest_step === null || -budget.nearest_step > budget.limit;
  const to = budget.sharp_to === null ? "on" : `to ${budget.sharp_to.toPrecision(3)}`;
  const sharp = `A panel shows distances from ${budget.sharp_from.toPrecision(3)} ${to} sharply.`;
  if (!behind && !front)
    return { level: "ok", text: `All of the scene is in the sharp depth. ${sharp}` };
  const where = behind && front ? "in front of and behind" : behind ? "behind" : "in front of";
  const blurred = budget.exceeded ? "looks double" : "is blurred";
  return {
    level: budget.exceeded ? "fail" : "note",
    text: `What is far ${where} the window ${blurred}. ${sharp}`,
  };
}
