#!/usr/bin/env python3
"""The stability suite `core` against its stored verdicts: a cell may improve, none may get worse.

  stability_core.py FEDER REAL            compare with tests/golden/stability_core_REAL.csv (REAL: float or double)
  stability_core.py --late FEDER REAL     of the problems that take long, which the first leaves out (LATE)
  stability_core.py --renew FEDER REAL    store the verdicts of this build instead; look at the diff before committing it

Every stored cell must be there again, unless its whole problem or method is not in this build. Cells of methods and
problems that are new are not compared; they need a renewal to be guarded. At least half of the stored cells must be
compared. Exit status 1 when a cell got worse or is missing.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile

# worst first, as in feder/study.h
ORDER = ["nan", "diverged", "growing", "stuck", "damped", "inaccurate", "slow", "refused", "stable"]
KEY = ("problem", "method", "x", "y")
# nets by every integrator, bodies, cloth, soft bodies and fluids by every solver of theirs
PROBLEMS = ("oscillator chain swinging_chain stack heavy size far bullet spin friction hinged_rod jointed_chain "
            "hanging_sheet drape pinned_gap sheet_substeps soft_bar soft_cantilever soft_scatter water_column floating water_substeps "
            "water_depth water_iterations").split()
LATE = ("hanging_sheet", "soft_scatter", "soft_cantilever")


def baseline(real):
    return pathlib.Path(__file__).resolve().parents[2] / "tests" / "golden" / f"stability_core_{real}.csv"


def measure(feder, problems):
    cells = {}
    for problem in problems:
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([feder, "stability", problem, "--suite", "core", "--quiet", "--out", folder], check=True,
                           stdout=subprocess.DEVNULL)
            with open(pathlib.Path(folder) / "cells.csv", newline="") as file:
                for row in csv.DictReader(file):
                    cells[tuple(row[k] for k in KEY)] = row["verdict"]
    return cells


def read(path):
    with open(path, newline="") as file:
        return {tuple(row[k] for k in KEY): row["verdict"] for row in csv.DictReader(file)}


def compare(now, stored):
    """Lines of complaint, and the number of cells compared; of stored cells of the problems that were run."""
    present = {cell[:2] for cell in now}
    complaints, compared = [], 0
    for cell, was in stored.items():
        if cell[:2] not in present:
            continue
        compared += 1
        name = f"{cell[0]} {cell[1]} x={cell[2]} y={cell[3]}"
        if cell not in now:
            complaints.append(f"{name}: was {was}, is missing")
        elif ORDER.index(now[cell]) < ORDER.index(was):
            complaints.append(f"{name}: was {was}, is {now[cell]}")
    if 2 * compared < len(stored) or compared == 0:
        complaints.append(f"only {compared} of {len(stored)} stored cells were compared")
    return complaints, compared


def renew(cells, path):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow((*KEY, "verdict"))
        writer.writerows((*cell, verdict) for cell, verdict in cells.items())
    print(f"stored {len(cells)} verdicts in {path}")
    return 0


def main(arguments):
    words = [a for a in arguments if a not in ("--renew", "--late")]
    if len(words) != 2 or words[1] not in ("float", "double"):
        print(__doc__, file=sys.stderr)
        return 2
    late, path = "--late" in arguments, baseline(words[1])
    if "--renew" in arguments:
        return renew(measure(words[0], PROBLEMS), path)
    problems = [p for p in PROBLEMS if (p in LATE) == late]
    now, stored = measure(words[0], problems), {c: v for c, v in read(path).items() if c[0] in problems}
    complaints, compared = compare(now, stored)
    for line in complaints:
        print(f"stability: {line}")
    better = sum(1 for c, v in now.items() if c in stored and ORDER.index(v) > ORDER.index(stored[c]))
    print(f"stability: {compared} cells compared, {better} better, {len(now) - compared} not stored")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
