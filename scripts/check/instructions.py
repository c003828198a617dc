#!/usr/bin/env python3
"""Instructions per step of a few scenes, counted by valgrind's callgrind, against stored numbers.

  instructions.py FEDER            compare; a scene may cost 1 % more than stored, all together 0.3 % (geometric mean);
                                   and what does nothing, in one build: ratios that need no stored numbers (IDLE)
  instructions.py --renew FEDER    store the numbers of this build under its key: an allowance, in a commit of its own
                                   that names what was mended and what it costs
  instructions.py --idle FEDER     only the latter; and print how the time of a body grows with the size of a pyramid

Only World::step is counted, in an empty environment, so the numbers repeat to the last digit on one machine. They are
stored by compiler, flags, valgrind and whether the processor has AVX2. A scene without a stored number fails, and one
that runs what it has no use for (a tower without joints: no function of joints). Exit
status 77 (skipped) when valgrind or all numbers of this key are missing; with CI in the environment that fails too.
"""
import functools
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BASELINE = ROOT / "tests" / "golden" / "instructions.json"
SCENES = {"scenes/springs/pendulum.lua": 0.25, "scenes/springs/hanging_net.lua": 0.25, "scenes/rigid/incline.lua": 0.5,
          "scenes/rigid/tower.lua": 0.5, "scenes/rigid/pyramid.lua": 0.1, "scenes/rigid/joint_grid.lua": 0.1,
          "scenes/cloth/flag.lua": 0.1, "scenes/fluid/dam_break.lua": 0.1, "scenes/fluid/droplet_2d.lua": 0.1,
          "scenes/mixed/everything.lua": 0.5}  # seconds simulated
ABSENT = {"scenes/rigid/tower.lua": r"[Jj]oint"}  # functions that a scene has no use for must not run
SCENE_LIMIT, MEAN_LIMIT = 1.01, 1.003
# What does nothing costs nothing: of tests/bench/idle.lua a step with the first settings takes at most `factor` times
# the instructions of one with the second, and `more`. Counted from step 20 to 60: trees and lists are made before.
IDLE_SCENE, IDLE_STEPS = "tests/bench/idle.lua", (20, 60)
IDLE = (  # what, settings, beside, settings, factor, more
    ("100,000 static boxes", {"static": 100000}, "100", {"static": 100}, 1.05, 0),
    ("10,000 boxes asleep", {"asleep": 10000}, "none", {}, 1, 5000),
    ("100 balls among 100,000 static boxes", {"moving": 100, "static": 100000}, "among 1,000",
     {"moving": 100, "static": 1000}, 1.5, 0),
    ("100 balls beside 10,000 boxes asleep", {"moving": 100, "asleep": 10000}, "beside none", {"moving": 100},
     1.15, 0))
GROWTH_SCENE, GROWTH_BASES, GROWTH_AIM = "scenes/rigid/pyramid.lua", (50, 200), 1.6  # times, so reported only


def first_line(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[0].strip()


def key_of(feder):
    cache = (pathlib.Path(feder).resolve().parent / "CMakeCache.txt").read_text()

    def cached(name):
        match = re.search(rf"^{name}:[A-Z]+=(.*)$", cache, re.M)
        return match.group(1) if match else ""

    kind = cached("CMAKE_BUILD_TYPE")
    flags = f"{cached('CMAKE_CXX_FLAGS')} {cached('CMAKE_CXX_FLAGS_' + kind.upper())}".strip()
    wide = "avx2" if "avx2" in pathlib.Path("/proc/cpuinfo").read_text() else "plain"
    lumps = ["lumps"] if cached("FEDER_PCH") == "ON" else []  # several sources per compilation inline otherwise
    return " | ".join([first_line(cached("CMAKE_CXX_COMPILER"), "--version"), flags, cached("FEDER_REAL"),
                       first_line("valgrind", "--version"), wide, *lumps])


def collected(feder, words):
    """Instructions in World::step, steps, and the text of callgrind's file."""
    with tempfile.TemporaryDirectory() as folder:
        out = subprocess.run(
            ["env", "-i", "PATH=/usr/bin:/bin", "valgrind", "--tool=callgrind", "--toggle-collect=feder::World::step()",
             f"--callgrind-out-file={folder}/out", feder, "run", *words, "--json", "--quiet"],
            capture_output=True, text=True, cwd=ROOT, check=False)
        ran = pathlib.Path(folder, "out").read_text() if out.returncode == 0 else ""
    found = re.search(r"Collected : (\d+)", out.stderr)
    if out.returncode != 0 or not found or int(found.group(1)) == 0:
        sys.exit(f"instructions: {' '.join(words)}: no count\n{out.stderr[-2000:]}")
    return int(found.group(1)), json.loads(out.stdout)["steps"], ran


def count(feder, scene, seconds):
    """Instructions per step."""
    instructions, steps, ran = collected(feder, [scene, "--seconds", str(seconds)])
    functions = re.findall(r"^c?fn=\(\d+\) (.*)", ran, re.M)
    idle = [f for f in functions if scene in ABSENT and re.search(ABSENT[scene], f)]
    if idle or not functions:
        sys.exit(f"instructions: {scene}: runs {', '.join(idle) or 'nothing'}")
    return instructions / steps


@functools.cache
def count_idle(feder, settings):
    """Instructions per step of IDLE_SCENE, between two steps."""
    words = [IDLE_SCENE, "--check", *(f"--set={name}={value}" for name, value in settings)]
    first, last = (collected(feder, [*words, "--steps", str(steps)])[0] for steps in IDLE_STEPS)
    return (last - first) / (IDLE_STEPS[1] - IDLE_STEPS[0])


def compare_idle(feder):
    bad = 0
    for what, settings, other, beside, factor, more in IDLE:
        now, base = (count_idle(feder, tuple(s.items())) for s in (settings, beside))
        most = factor * base + more
        rule = f"{factor:g} times{f' and {more:,}' if more else ''}"
        print(f"  {what}: {now:,.0f} per step, {other}: {base:,.0f}; {now / base:.3g} times, at most {rule}"
              + ("" if now <= most else ": MORE"))
        bad += now > most
    if bad:
        print(f"instructions: {bad} of {len(IDLE)} cost more than what does nothing may")
    return 1 if bad else 0


def growth(feder):
    """How the time of a body and step grows with the pyramid: a report, because times vary."""
    times = []
    for base in GROWTH_BASES:
        out = subprocess.run([feder, "bench", GROWTH_SCENE, "--set", f"base={base}", "--steps", "40", "--runs", "3",
                              "--json"], capture_output=True, text=True, cwd=ROOT, check=True)
        times.append(1e3 * json.loads(out.stdout)["ms_per_step"]["min"] / (base * (base + 1) / 2))
    bodies = " and ".join(f"{time:.2f} us at base {base}" for time, base in zip(times, GROWTH_BASES))
    return f"  a body of a pyramid: {bodies}, {times[1] / times[0]:.2f} times (aim: {GROWTH_AIM}; no gate)"


def compare(counts, stored):
    bad, logs = [], []
    for scene, now in counts.items():
        was = stored.get(scene)
        if was is None:
            bad.append(f"{scene}: {now:.1f} per step, not stored: --renew, in a commit that says what it costs")
            continue
        logs.append(math.log(now / was))
        print(f"  {scene}: {now:.1f} per step, stored {was:.1f} ({100 * (now / was - 1):+.2f} %)")
        if now > SCENE_LIMIT * was:
            bad.append(f"{scene}: more than {100 * (SCENE_LIMIT - 1):.0f} % above the stored number")
    mean = math.exp(sum(logs) / len(logs)) if logs else 1
    if mean > MEAN_LIMIT:
        bad.append(f"all scenes together: {100 * (mean - 1):+.2f} %, more than {100 * (MEAN_LIMIT - 1):.1f} % above")
    for line in bad:
        print(f"instructions: {line}")
    return 1 if bad else 0


def main(arguments):
    words = [a for a in arguments if a not in ("--renew", "--idle")]
    if len(words) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    feder = str(pathlib.Path(words[0]).resolve())
    if not shutil.which("valgrind"):
        print("instructions: skipped, valgrind is not there")
        return 1 if os.environ.get("CI") else 77
    ratios = 0 if "--renew" in arguments else compare_idle(feder)
    if "--idle" in arguments:
        print(growth(feder))
        return ratios
    stored = json.loads(BASELINE.read_text()) if BASELINE.exists() else {}
    key = key_of(feder)
    if "--renew" not in arguments and key not in stored:
        print(f"instructions: no numbers stored for {key}")
        return 1 if ratios or os.environ.get("CI") else 77
    counts = {scene: count(feder, scene, seconds) for scene, seconds in SCENES.items()}
    if "--renew" in arguments:
        stored[key] = counts
        BASELINE.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n")
        print(f"instructions: stored {len(counts)} scenes for {key}")
        return 0
    return max(ratios, compare(counts, stored[key]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
