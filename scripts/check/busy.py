#!/usr/bin/env python3
"""More threads must neither cost time nor change a bit on a busy machine: busy.py FEDER.

Scenes of every system with 1, 2 and 4 threads, beside as many processes that only burn processor time as there are
cores (two at least). Wall-clock time per step, runs interleaved, median of 7; at most 1.3 times that of one thread. The
hash after the run is the same for all of them."""
import json
import os
import statistics
import subprocess
import sys

RUNS = 7
THREADS = ("1", "2", "4")
LIMIT = 1.3
SCENES = (["scenes/rigid/pyramid.lua", "--set", "base=25"], ["scenes/rigid/bridge.lua"], ["scenes/cloth/flag.lua"],
          ["scenes/fluid/dam_break.lua"], ["scenes/mixed/everything.lua"])
STEPS = "60"


def measure(program, scene, threads):
    out = subprocess.run([program, "bench", *scene, "--runs", "1", "--steps", STEPS, "--threads", threads, "--json"],
                         capture_output=True, text=True, check=True)
    result = json.loads(out.stdout)
    return result["ms_per_step"]["median"], result["hash"]


def compare(program, scene):
    times, hashes = {t: [] for t in THREADS}, set()
    for _ in range(RUNS):
        for t in THREADS:
            ms, hash_ = measure(program, scene, t)
            times[t].append(ms)
            hashes.add(hash_)
    median = {t: statistics.median(times[t]) for t in THREADS}
    bad = len(hashes) - 1
    if bad:
        print(f"busy: {scene[0]}: hashes differ")
    for t in THREADS:
        ratio = median[t] / median["1"]
        bad += ratio > LIMIT
        print(f"busy: {scene[0]}, {t} threads: {median[t]:.2f} ms per step, {ratio:.2f} of one (at most {LIMIT}); "
              f"{min(times[t]):.2f} to {max(times[t]):.2f}")
    return bad


def main(program):
    os.chdir(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
    burners = [subprocess.Popen([sys.executable, "-c", "while True: pass"])
               for _ in range(max(2, len(os.sched_getaffinity(0))))]
    try:
        return 1 if sum(compare(program, scene) for scene in SCENES) else 0
    finally:
        for b in burners:
            b.kill()
            b.wait()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
