#!/usr/bin/env python3
"""Instructions per step of a few scenes, counted by valgrind's callgrind, against stored numbers.

  instructions.py FEDER            compare; a scene may cost 1 % more than stored, all together 0.3 % (geometric mean)
  instructions.py --renew FEDER    store the numbers of this build under its key: an allowance, in a commit of its own
                                   that names what was mended and what it costs

Only World::step is counted, in an empty environment, so the numbers repeat to the last digit on one machine. They are
stored by compiler, flags, valgrind and whether the processor has AVX2. A scene without a stored number fails, and one
that runs what it has no use for (a tower without joints: no function of joints). Exit
status 77 (skipped) when valgrind or all numbers of this key are missing; with CI in the environment that fails too.
"""
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


def count(feder, scene, seconds):
    """Instructions per step."""
    with tempfile.TemporaryDirectory() as folder:
        out = subprocess.run(
            ["env", "-i", "PATH=/usr/bin:/bin", "valgrind", "--tool=callgrind", "--toggle-collect=feder::World::step()",
             f"--callgrind-out-file={folder}/out", feder, "run", scene, "--seconds", str(seconds), "--json", "--quiet"],
            capture_output=True, text=True, cwd=ROOT, check=False)
        ran = pathlib.Path(folder, "out").read_text() if out.returncode == 0 else ""
    collected = re.search(r"Collected : (\d+)", out.stderr)
    if out.returncode != 0 or not collected or int(collected.group(1)) == 0:
        sys.exit(f"instructions: {scene}: no count\n{out.stderr[-2000:]}")
    functions = re.findall(r"^c?fn=\(\d+\) (.*)", ran, re.M)
    idle = [f for f in functions if scene in ABSENT and re.search(ABSENT[scene], f)]
    if idle or not functions:
        sys.exit(f"instructions: {scene}: runs {', '.join(idle) or 'nothing'}")
    return int(collected.group(1)) / json.loads(out.stdout)["steps"]


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
    words = [a for a in arguments if a != "--renew"]
    if len(words) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    feder = str(pathlib.Path(words[0]).resolve())
    if not shutil.which("valgrind"):
        print("instructions: skipped, valgrind is not there")
        return 1 if os.environ.get("CI") else 77
    stored = json.loads(BASELINE.read_text()) if BASELINE.exists() else {}
    key = key_of(feder)
    if "--renew" not in arguments and key not in stored:
        print(f"instructions: no numbers stored for {key}")
        return 1 if os.environ.get("CI") else 77
    counts = {scene: count(feder, scene, seconds) for scene, seconds in SCENES.items()}
    if "--renew" in arguments:
        stored[key] = counts
        BASELINE.write_text(json.dumps(stored, indent=1, sort_keys=True) + "\n")
        print(f"instructions: stored {len(counts)} scenes for {key}")
        return 0
    return compare(counts, stored[key])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
