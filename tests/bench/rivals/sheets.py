"""A sheet of 3 m hung at two corners, in feder at default settings and in Bullet at the same worst strain.

Bullet is given as many time steps of a frame with one iteration, or as many iterations of one step, as it takes until
no thread is stretched more than feder's worst in the last second: its figures are those of that number. feder's sheet
collides with itself by default, Bullet's does not: feder is measured with and without. What a constraint costs is the
processor time of a frame over constraints and the times that each was solved in it, all else included.

A run replaces the rows of its engines in tests/bench/sheets.csv; rows with 0 rounds were measured by hand, with the
engines' own programs on the same kind of machine. The table of README.md is made from it:
scripts/check/figures.py --renew build/release/feder sheets.
"""
import csv
import datetime
import math
import os
import pathlib
import platform
import statistics
import sys

STORED = pathlib.Path(__file__).resolve().parents[1] / "sheets.csv"
SIDES = (50, 100)  # vertices
SECONDS, TIMED = 4, 1
# By iterations alone the larger sheet takes Bullet seconds a frame.
LARGEST_BY_ITERATIONS = 50
LIMIT = 20000
COLUMNS = ("side_vertices", "engine", "version", "flags", "machine", "date", "rounds", "others", "how", "links",
           "bends", "sweeps", "frame_ms", "row_ns", "worst", "median")


def count_for(strain, worst_of):
    """The least number at which worst_of(number) <= strain, by the power law that the last two tries lie on."""
    low, high = (0, math.inf), None  # too few, and enough: number and worst strain
    count = 4
    while True:
        worst = worst_of(count)
        if worst <= strain:
            high = count, worst
        else:
            low = count, worst
        if high and high[0] - low[0] <= max(1, high[0] // 50):
            return high[0]
        if not high:
            if count >= LIMIT:
                return None
            count = min(LIMIT, 2 * count if not worst < 20 * strain else math.ceil(count * (worst / strain) ** .55))
        else:
            power = math.log(low[1] / high[1]) / math.log(high[0] / low[0]) if 0 < low[0] and low[1] < 1 else 0
            guess = low[0] * (low[1] / strain) ** (1 / power) if power > .1 else (low[0] + high[0]) / 2
            count = min(max(math.ceil(guess), low[0] + 1), high[0] - 1)


def measure(programs, options, run):
    """Rows by (side, engine, how)."""
    jobs = {}  # (side, engine, how): words of its program

    def try_one(engine, side, substeps, iterations, own=1):
        print(f"\r{side} x {side}: {engine}, {substeps} steps, {iterations} iterations".ljust(79), end="",
              file=sys.stderr, flush=True)
        found = run(programs[engine], side, SECONDS, TIMED, substeps, iterations, own)
        return found or sys.exit(1)

    for side in SIDES:
        jobs[side, "feder", "default"] = (side, 0, 0, 1)
        jobs[side, "feder", "without self-contact"] = (side, 0, 0, 0)
        if "bullet" not in programs:
            continue
        strain = try_one("feder", side, 0, 0)["worst"]
        count = count_for(strain, lambda n, side=side: try_one("bullet", side, n, 1)["worst"])
        if count:
            jobs[side, "bullet", f"{count} steps a frame"] = (side, count, 1, 1)
        if side > LARGEST_BY_ITERATIONS:
            continue
        count = count_for(strain, lambda n, side=side: try_one("bullet", side, 1, n)["worst"])
        if count:
            jobs[side, "bullet", f"{count} iterations"] = (side, 1, count, 1)
    runs = {}
    for _ in range(options.rounds):
        for key, words in jobs.items():
            runs.setdefault(key, []).append(try_one(key[1], *words))
    print(file=sys.stderr)
    rows = {}
    for key, found in runs.items():
        rows[key] = {**found[0], "rounds": len(found), "how": key[2]}
        for column in ("frame_ms", "row_ns", "others"):
            rows[key][column] = statistics.median(r[column] for r in found)
    return rows


def stored():
    if not STORED.is_file():
        return []
    with open(STORED, newline="") as file:
        return list(csv.DictReader(file))


def main(programs, options, run, versions):
    rows = measure(programs, options, run)
    for row in rows.values():
        row["version"], row["flags"] = versions[row["engine"]]
        row["machine"], row["date"] = f"{os.cpu_count()} cores {platform.machine()}", datetime.date.today().isoformat()
    new = [{c: f"{row[c]:.4g}" if isinstance(row[c], float) else row[c] for c in COLUMNS} for row in rows.values()]
    for row in new:
        print(f"{row['side_vertices']} x {row['side_vertices']} {row['engine']}, {row['how']}: {row['frame_ms']} ms a "
              f"frame, worst strain {row['worst']}, {row['row_ns']} ns a constraint and sweep")
    measured = {row["engine"] for row in new}
    new += [row for row in stored() if row["engine"] not in measured]
    target = options.out or STORED
    with open(target, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(new)
    print(f"rows are in {target}")
    return 0
