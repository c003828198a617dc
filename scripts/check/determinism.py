#!/usr/bin/env python3
"""Equal hashes for every scene from several builds and thread counts, and when all that is kept beside the state is made
anew in every step: determinism.py [--seconds S] FEDER [FEDER...]."""
import argparse
import json
import pathlib
import subprocess
import sys

WAYS = ("--threads 1", "--threads 2", "--threads 4", "--world rebuild=true")


def final_hash(program, scene, seconds, way):
    out = subprocess.run([program, "run", str(scene), "--json", "--quiet", "--seconds", seconds, *way.split()],
                         capture_output=True, text=True, check=False)
    try:
        return json.loads(out.stdout)["hash"]
    except (ValueError, KeyError):
        return "no result: " + (out.stderr.strip().splitlines() or ["?"])[-1]


def main(seconds, programs):
    root = pathlib.Path(__file__).resolve().parents[2]
    scenes = sorted(p for p in (root / "scenes").rglob("*.lua") if "feder.scene" in p.read_text())
    bad = 0
    for scene in scenes:
        hashes = {(p, t): final_hash(p, scene, seconds, t) for p in programs for t in WAYS}
        if len(set(hashes.values())) > 1 or next(iter(hashes.values())).startswith("no result"):
            bad += 1
            print(f"{scene.relative_to(root)}: hashes differ")
            for (program, way), value in hashes.items():
                print(f"  {program} {way}: {value}")
    print(f"determinism: {len(scenes)} scenes, {len(programs)} builds, {', '.join(WAYS)}: {bad} differ")
    return 1 if bad or not scenes else 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--seconds", default="3", help="of simulated time")
    parser.add_argument("programs", nargs="+", metavar="FEDER")
    given = parser.parse_args()
    sys.exit(main(given.seconds, given.programs))
