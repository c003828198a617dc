"""A gas of boxes through the broad phases of feder and of Bullet, in one program, one after another.

Time is processor time of a step: all boxes given anew, their pairs listed. A run replaces tests/bench/boxes.csv; the
table of runtime/README.md is made from it: scripts/check/figures.py --renew build/release/feder broad_phases.
"""
import csv
import datetime
import os
import pathlib
import platform
import statistics

STORED = pathlib.Path(__file__).resolve().parents[1] / "boxes.csv"
COUNTS = (1000, 4000)
SPEEDS = (.003, .03, .3, 1)  # most that a box goes by in a step, in shares of its size
STEPS, REPEATS = 60, 3
COLUMNS = ("boxes", "speed", "engine", "method", "version", "machine", "date", "rounds", "step_ms", "pairs")


def main(program, options, call, versions):
    runs = {}
    for _ in range(options.rounds):
        for count in COUNTS:
            for speed in SPEEDS:
                for line in call(program, count, speed, STEPS, REPEATS).splitlines():
                    engine, method, ms, pairs = line.split()
                    runs.setdefault((count, speed, engine, method, pairs), []).append(float(ms))
    target = options.out or STORED
    where = f"{os.cpu_count()} cores {platform.machine()}", datetime.date.today().isoformat(), options.rounds
    with open(target, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for (count, speed, engine, method, pairs), found in runs.items():
            ms = statistics.median(found)
            writer.writerow((count, speed, engine, method, versions[engine][0], *where, f"{ms:.4g}", pairs))
            print(f"{count} boxes, speed {speed:g}, {engine} {method}: {ms:.4g} ms a step, {pairs} pairs")
    print(f"rows are in {target}")
    return 0
