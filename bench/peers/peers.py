#!/usr/bin/env python3
"""bench-peers: the error of quiltrender's views and of Cycles' after equal CPU time, in one interleaved run.

Both render the same scenes: Cycles a few single views, quiltrender all views at once. Each is held against its own converged
reference, made twice, so that the references' own error can be taken off. What counts is relMSE x CPU seconds per view: by how much
one renderer must be given more time until both are equally far from the truth. Rendering alone is timed: of quiltrender what
--stats calls cpu_seconds, of Cycles the difference between many samples and one, so that start-up, export, hierarchy and files
stay out of both.

Everything lands in OUT: pictures, peers.json, and the table on stdout as peers.txt. Exit 1 when the renderers' references disagree:
then they did not render the same scene.
"""

import argparse
import contextlib
import json
import os
import shutil
import statistics
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
AGREE = 0.005  # of a view's mean, between the two references, and three standard errors of the difference


class Failed(Exception):
    pass


def run(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failed(f"{command[0]}: exit {done.returncode}: {(done.stderr.strip().splitlines() or ['no word'])[-1]}")
    return done.stdout


class Cycles:
    """A Blender that renders views on request (cycles.py)."""

    def __init__(self, options, scene, log):
        self.where = f"Blender with {os.path.basename(scene)}"
        self.log = log
        width, height = options.size.split("x")
        self.log_file = open(log, "w", encoding="utf-8")
        self.process = subprocess.Popen(
            [options.blender, "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python",
             os.path.join(HERE, "cycles.py"), "--", scene, width, height, str(options.threads), str(options.step_rate)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.log_file, text=True)
        self.answer()

    def answer(self):
        for line in self.process.stdout:
            if line.startswith("PEERS "):
                return json.loads(line[len("PEERS "):])
            self.log_file.write(line)
        self.log_file.flush()
        with open(self.log, encoding="utf-8") as log:
            said = [line.strip() for line in log if line.startswith("cycles.py: ")] or [f"ended early; see {self.log}"]
        raise Failed(f"{self.where}: {said[-1]}")

    def render(self, view, samples, seed, file):
        """CPU seconds of everything between the request and the written file."""
        json.dump({"view": view, "samples": samples, "seed": seed, "file": os.path.abspath(file)}, self.process.stdin)
        self.process.stdin.write("\n")
        self.process.stdin.flush()
        answer = self.answer()
        if not os.path.exists(file):
            raise Failed(f"{self.where}: wrote no {file}")
        return answer["cpu_seconds"]

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()
        self.log_file.close()


def quiltrender(options, scene, out, spp, estimator, seed):
    """Renders all views into the folder out; what --stats says."""
    stats = out + ".json"
    run([os.path.join(options.build, "quiltrender"), scene, "-o", out + "/", "--view-size", options.size, "--spp", str(spp),
         "--integrator", "mvpt", "--estimator", estimator, "--threads", str(options.threads), "--seed", str(seed),
         "--stats", stats])
    with open(stats, encoding="utf-8") as file:
        return json.load(file)


def compare(options, reference, picture):
    return json.loads(run([os.path.join(options.build, "quiltbench"), "error", reference, picture, "--json", "-"]))


def rel_mse(options, references, picture):
    """Without the references' own error: e(x, A) = var x + var A, e(x, B) = var x + var B, e(A, B) = var A + var B."""
    a, b = references
    between = compare(options, a, b)["rel_mse"]
    return (compare(options, a, picture)["rel_mse"] + compare(options, b, picture)["rel_mse"] - between) / 2


def view_file(folder, view):
    return os.path.join(folder, f"view_{view:03d}.exr")


def say(text):
    if sys.stderr.isatty():
        print(f"\rbench-peers: {text}\033[K", end="", file=sys.stderr, flush=True)


def make_references(options, scene, cycles, out):
    """The folders of two references of either renderer."""
    ours = [os.path.join(out, f"quilt_reference_{half}") for half in "ab"]
    theirs = [os.path.join(out, f"cycles_reference_{half}") for half in "ab"]
    for half in range(2):
        say(f"{os.path.basename(scene)}: references, half {half + 1} of 2")
        quiltrender(options, scene, ours[half], options.reference_spp, "cv", 1000 + half)
        for view in options.views:
            cycles.render(view, options.cycles_reference_spp, 1000 + half, view_file(theirs[half], view))
    return ours, theirs


def run_ours(options, scene, references, out, seed):
    stats = quiltrender(options, scene, out, options.spp, options.estimator, seed)
    views = stats["views"]
    return {"rel_mse": rel_mse(options, references, out), "cpu_seconds": stats["cpu_seconds"] / views, "views": views}


def run_cycles(options, cycles, references, out, seed):
    """Means over the views."""
    error = cpu = 0
    samples = options.cycles_spp
    for view in options.views:
        one = cycles.render(view, 1, seed, view_file(out, view))
        many = cycles.render(view, samples, seed, view_file(out, view))
        cpu += (many - one) * samples / (samples - 1)
        error += rel_mse(options, [view_file(folder, view) for folder in references], view_file(out, view))
    return {"rel_mse": error / len(options.views), "cpu_seconds": cpu / len(options.views), "views": len(options.views)}


def agreement(options, ours, theirs):
    """How far Cycles' reference is from ours, view by view."""
    found = []
    for view in options.views:
        halves = [compare(options, view_file(a, view), view_file(b, view)) for a, b in zip(ours, theirs)]
        noise = [compare(options, view_file(a, view), view_file(b, view))["rel_mse"] for a, b in (ours, theirs)]
        found.append({
            "view": view, "relative_mean": statistics.mean(h["relative_mean"] for h in halves),
            "relative_mean_se": statistics.mean(h["bias_se"] / h["reference_mean"] for h in halves),
            "block_rms": statistics.mean(h["block_rms"] for h in halves),
            "rel_mse": statistics.mean(h["rel_mse"] for h in halves), "rel_mse_of_noise": sum(noise) / 2})
    return found


def measure(options, scene):
    name = os.path.splitext(os.path.basename(scene))[0]
    out = os.path.join(options.out, name)
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    with contextlib.closing(Cycles(options, scene, os.path.join(out, "blender.log"))) as cycles:
        ours, theirs = make_references(options, scene, cycles, out)
        runs = {"quiltrender": [], "cycles": []}
        for i in range(options.seeds):
            say(f"{name}: seed {i + 1} of {options.seeds}")
            turns = [("quiltrender", lambda folder: run_ours(options, scene, ours, folder, i + 1)),
                     ("cycles", lambda folder: run_cycles(options, cycles, theirs, folder, i + 1))]
            for who, turn in turns if i % 2 == 0 else reversed(turns):
                runs[who].append(turn(os.path.join(out, f"{who}_{i + 1}")))
    ratios = [product(c) / product(q) for c, q in zip(runs["cycles"], runs["quiltrender"])]
    return {"scene": name, **runs, "ratios": ratios, "ratio_median": statistics.median(ratios),
            "agreement": agreement(options, ours, theirs)}


def product(one):
    return one["rel_mse"] * one["cpu_seconds"]


def line_of(name, runs, what):
    error, cpu = (statistics.median(r[key] for r in runs) for key in ("rel_mse", "cpu_seconds"))
    products = sorted(map(product, runs))
    return (f"{name:12} {error:10.3e} {cpu:10.4f}   {statistics.median(products):10.3e}  ({products[0]:.2e} .. {products[-1]:.2e})"
            f"   {what}")


def table(options, result):
    ours, theirs, ratios = result["quiltrender"], result["cycles"], sorted(result["ratios"])
    views = ", ".join(map(str, options.views))
    lines = [f"{result['scene']}: views of {options.size}, {options.threads} threads; medians over {options.seeds} seeds "
             "(lowest .. highest)",
             "                 relMSE  CPU s/view   relMSE x CPU s/view",
             line_of("Cycles", theirs, f"{options.cycles_spp} samples, views {views}"),
             line_of("quiltrender", ours, f"{options.spp} spp, mvpt {options.estimator}, {ours[0]['views']} views"),
             f"Cycles over quiltrender: {result['ratio_median']:.1f}  ({ratios[0]:.1f} .. {ratios[-1]:.1f})"]
    for view in result["agreement"]:
        lines.append(f"references, view {view['view']}: Cycles' mean {100 * view['relative_mean']:+.3f} %; 7x7 blocks differ by "
                     f"{100 * view['block_rms']:.2f} % rms; relMSE {view['rel_mse']:.2e}, "
                     f"noise alone {view['rel_mse_of_noise']:.2e}")
    return "\n".join(lines) + "\n"


def disagreement(results):
    for result in results:
        for view in result["agreement"]:
            allowed = AGREE + 3 * view["relative_mean_se"]
            if not abs(view["relative_mean"]) <= allowed:
                return (f"{result['scene']}: view {view['view']}: the references' means differ by "
                        f"{100 * view['relative_mean']:+.2f} %, more than {100 * allowed:.2f} %")
    return None


def settings_of(options):
    version = run([options.blender, "--version"]).splitlines()[0]
    return {"blender": version, "cpu": cpu_model(), "size": options.size, "threads": options.threads, "views": options.views,
            "cycles": {"samples": options.cycles_spp, "reference_samples": 2 * options.cycles_reference_spp,
                       "step_rate": options.step_rate, "bounces": 1024, "denoiser": False, "adaptive_sampling": False,
                       "clamping": False},
            "quiltrender": {"integrator": "mvpt", "estimator": options.estimator, "spp": options.spp,
                            "reference_spp": 2 * options.reference_spp, "reference_estimator": "cv"}}


def cpu_model():
    with open("/proc/cpuinfo", encoding="utf-8") as file:
        return next((line.split(":", 1)[1].strip() for line in file if line.startswith("model name")), "unknown")


def write(path, text):
    with open(path + ".new", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".new", path)


def size(text):
    width, height = map(int, text.split("x"))
    if width < 1 or height < 1:
        raise ValueError(text)
    return f"{width}x{height}"


def at_least(least):
    def count(text):
        if int(text) < least:
            raise ValueError(text)
        return int(text)
    return count


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add = parser.add_argument
    add("scenes", nargs="+", metavar="SCENE.json")
    add("--build", default="build", help="where quiltrender and quiltbench are (build)")
    add("--out", default="build/bench/peers", help="folder for everything (build/bench/peers)")
    add("--blender", default="blender")
    add("--size", type=size, default="60x80", help="of a view (60x80)")
    add("--views", type=lambda text: [int(v) for v in text.split(",")], default=[0, 22, 44], help="that Cycles renders (0,22,44)")
    add("--seeds", type=at_least(1), default=8)
    add("--threads", type=at_least(1), default=len(os.sched_getaffinity(0)), help="of either renderer (all CPUs)")
    add("--spp", type=at_least(1), default=4, help="of quiltrender (4)")
    add("--estimator", choices=("mwis", "mis", "cv"), default="mwis")
    add("--reference-spp", type=at_least(1), default=32, help="of each half of our reference (32)")
    add("--cycles-spp", type=at_least(2), default=16, help="samples of Cycles (16)")
    add("--cycles-reference-spp", type=at_least(1), default=64, help="of each half of its reference (64)")
    add("--step-rate", type=float, default=1, help="Cycles' volume step rate (1: a step a voxel)")
    return parser.parse_args()


def main():
    options = parse()
    if not shutil.which(options.blender):
        raise Failed(f"{options.blender}: not found; .ci/deps install peers installs it")
    os.makedirs(options.out, exist_ok=True)
    settings, results = settings_of(options), []
    text = (f"{settings['blender']}: step rate {options.step_rate:g}, {settings['cycles']['bounces']} bounces, no denoiser, "
            "no adaptive sampling, no clamping\n"
            f"references: Cycles 2 x {options.cycles_reference_spp} samples, quiltrender 2 x {options.reference_spp} spp (cv)\n"
            f"machine: {settings['cpu']}, {options.threads} threads\n")
    print(text, flush=True)
    for scene in options.scenes:
        results.append(measure(options, scene))
        say("")
        block = "\n" + table(options, results[-1])
        text += block
        print(block.lstrip("\n"), flush=True)
        write(os.path.join(options.out, "peers.txt"), text)
        write(os.path.join(options.out, "peers.json"), json.dumps({**settings, "scenes": results}, indent=2) + "\n")
    problem = disagreement(results)
    if problem:
        raise Failed(problem)


try:
    main()
except (Failed, OSError) as error:
    print(f"bench-peers: {error}", file=sys.stderr)
    sys.exit(1)
