// Numbers of the daemon in words.
import assert from "node:assert/strict";
import { test } from "node:test";
import {
  bytesText,
  depthText,
  describe,
  duration,
  progressOf,
  secondsLeft,
  sortFindings,
} from "../../../web/page/words.js";

test("times are round", () => {
  const words = [0.2, 44, 50, 200, 620, 4000, 5399, 5400, 1e6].map(duration);
  assert.deepEqual(words, [
    "less than a minute",
    "less than a minute",
    "about 1 min",
    "about 3 min",
    "about 10 min",
    "about 60 min",
    "about 60 min",
    "hours",
    "hours",
  ]);
});

test("the time left is the daemon's, or follows from the error", () => {
  const status = { error_estimate: 4e-4, target_error: 1e-4, seconds: 10 };
  assert.ok(Math.abs(secondsLeft(status) - 30) < 1e-9);
  assert.ok(Math.abs(secondsLeft({ ...status, error_bound: 2e-4 }) - 10) < 1e-9);
  assert.equal(secondsLeft({ ...status, seconds_left: 7 }), 7);
  assert.equal(secondsLeft({ ...status, seconds_left: null }), undefined);
  assert.equal(secondsLeft({ ...status, error_estimate: null }), undefined);
});

test("a line says what is waited for", () => {
  const status = { state: "rendering", scene: "/srv/b.glb", level: "none", passes: 0 };
  assert.equal(describe(status), "waiting for the first image");
  assert.equal(
    describe({ ...status, state: "paused", paused: true }),
    "Paused: press Pause to see the change",
  );
  assert.equal(describe({ ...status, paused: true, level: "coarse", state: "paused", passes: 2 }), "paused · coarse · 2.00 passes");
  const load = { kind: "file", file: "/srv/next.obj" };
  assert.match(describe({ ...status, level: "complete", load }), /^loading next\.obj/);
  assert.match(describe({ ...status, level: "complete", load: { kind: "orbit", file: null } }), /^complete/);
  assert.equal(describe({ is_quilt: true, views: 1 }), "finished image · 1 view");
  const video = { seconds: 3.23, duration: 10, frame: 97, paused: true, problem: null };
  assert.equal(
    describe({ is_quilt: true, views: 48, video }),
    "video · 3.2 of 10.0 s · frame 97 · paused · 48 views",
  );
  const stopped = { ...video, duration: null, problem: "broken" };
  assert.equal(
    describe({ is_quilt: true, views: 48, video: stopped }),
    "video · 3.2 s · frame 97 · stopped · 48 views",
  );
  assert.equal(describe({ is_quilt: true, views: 1 }, "", true), "waiting for the first image");
});

test("progress goes from an error of 1 to the target", () => {
  assert.equal(progressOf(1, 1e-4), 0);
  assert.ok(Math.abs(progressOf(1e-2, 1e-4) - 0.5) < 1e-9);
  assert.equal(progressOf(1e-5, 1e-4), 1);
  assert.equal(progressOf(null, 1e-4), 0);
  assert.equal(progressOf(7, 1e-4), 0);
});

test("with a simulated panel, notes about hardware are apart", () => {
  const findings = [
    { level: "ok", text: "daemon: idle" },
    { level: "note", text: "udev rule: not installed" },
    { level: "note", text: "USB: no bus" },
    { level: "fail", text: "panels: broken" },
    { level: "note", text: "service: not running" },
  ];
  const { shown, folded } = sortFindings(findings, "sim");
  assert.deepEqual(folded, [findings[1], findings[2]]);
  assert.deepEqual(shown, [findings[0], findings[3], findings[4]]);
  assert.deepEqual(sortFindings(findings, "drm"), { shown: findings, folded: [] });
});

test("sizes have units", () => {
  assert.deepEqual([0, 999, 1500, 15e6, 3e9].map(bytesText), [
    "0 bytes",
    "999 bytes",
    "1.5 kB",
    "15 MB",
    "3.0 GB",
  ]);
});

test("the depth budget says what is not sharp, and where", () => {
  const budget = {
    nearest_step: -3,
    farthest_step: 4,
    limit: 5,
    sharp_from: 9,
    sharp_to: 14,
    exceeded: false,
  };
  assert.equal(depthText(null).level, "note");
  assert.equal(depthText(budget).level, "ok");
  assert.match(
    depthText({ ...budget, farthest_step: 6, exceeded: true }).text,
    /far behind the window looks double/,
  );
  assert.match(
    depthText({ ...budget, nearest_step: -6, exceeded: true }).text,
    /far in front of the window/,
  );
  assert.match(
    depthText({ ...budget, nearest_step: null, exceeded: true }).text,
    /far in front of the window/,
  );
  assert.match(depthText({ ...budget, farthest_step: 6 }).text, /is blurred/); // by view_blur
  assert.match(depthText({ ...budget, sharp_to: null }).text, /from 9\.00 on sharply/);
});
