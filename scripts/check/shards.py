#!/usr/bin/env python3
"""A study cut into shards, run side by side by GNU parallel (xargs -P where that is missing), put together again by
`feder study --merge`: every byte of points.csv must be that of the study run at once.

  shards.py FEDER
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

STUDY = ["study", "oscillator", "--methods", "rk4,leapfrog,bdf2,rk45", "--repeat", "0", "--quiet"]
SHARDS = 4


def side_by_side(feder, folder):
    numbers = [str(i + 1) for i in range(SHARDS)]
    command = [feder, *STUDY, "--shard", f"{{}}/{SHARDS}", "--out", "part{}"]
    if shutil.which("parallel"):
        tool = ["parallel", "--will-cite", "--jobs", "2", *command, ":::", *numbers]
        return subprocess.run(tool, cwd=folder, stdout=subprocess.DEVNULL, check=False).returncode, "GNU parallel"
    tool = ["xargs", "-P", "2", "-I", "{}", *command]
    return subprocess.run(tool, cwd=folder, input="\n".join(numbers), text=True, stdout=subprocess.DEVNULL,
                          check=False).returncode, "xargs -P"


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    feder = str(pathlib.Path(arguments[0]).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([feder, *STUDY, "--out", "whole"], cwd=folder, stdout=subprocess.DEVNULL, check=True)
        status, tool = side_by_side(feder, folder)
        parts = sorted(str(p) for p in folder.glob("part*/report.json"))
        if status != 0 or len(parts) != SHARDS:
            print(f"shards: {tool} ended with {status}, {len(parts)} of {SHARDS} parts")
            return 1
        subprocess.run([feder, "study", "--merge", *parts, "--out", "merged", "--quiet"], cwd=folder,
                       stdout=subprocess.DEVNULL, check=True)
        whole, merged = ((folder / d / "points.csv").read_bytes() for d in ("whole", "merged"))
        shares = [(folder / f"part{i + 1}" / "points.csv").read_text().count("\n") - 1 for i in range(SHARDS)]
        rows = whole.count(b"\n") - 1
        if merged != whole or sum(shares) != rows or min(shares) == 0:
            print(f"shards: the parts ({shares} rows) put together are not the whole ({rows} rows)")
            return 1
    print(f"shards: {tool}, {shares} rows, together the {rows} of the whole")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
