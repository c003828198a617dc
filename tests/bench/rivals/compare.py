#!/usr/bin/env python3
"""Times and end states of rigid bodies in feder and in other engines, side by side; scripts/compare runs this.

The scenes are those of scenes.cpp; every engine has its own default settings. Engines run in turn, each in a process of
its own, in rounds; figures are medians. Processor time counts all threads of a process, and is what one thread costs
also on a busy machine; of several threads the wall clock tells, on a quiet one. Memory is what the process grows from
the empty world to step 100; Jolt makes some of its room before. `others` is the share of the machine's processor time
that other processes took meanwhile: runs with more than .05 count only where there is no better one, and say little of
several threads. Overlaps and joint errors are measured from poses, the same way for all engines.

A run replaces the rows of its scenes in tests/bench/rivals.csv, when it ran all engines, thread counts and steps that
these rows have; else its rows go to build/compare/rivals.csv. The tables of the documents are made from the former:
scripts/check/figures.py --renew build/release/feder rivals rivals_all. --sheets hangs up cloth instead: sheets.py;
--boxes compares broad phases: boxes.py.
"""
import argparse
import csv
import datetime
import fcntl
import json
import os
import pathlib
import platform
import re
import resource
import statistics
import subprocess
import sys

import aims
import boxes
import sheets

ROOT = pathlib.Path(__file__).resolve().parents[3]
HERE = ROOT / "tests/bench/rivals"
WORK = ROOT / "build/compare"
STORED = ROOT / "tests/bench/rivals.csv"
ENGINES = ("feder", "box3d", "jolt", "bullet")
# modules of feder that bodies and cloth do not need: the build is shorter, and the same
WITHOUT = "springs;rope;fluid;couple;study;record"
QUIET = .05  # of the machine, taken by others
MEASURED = ("processor_ms", "wall_ms", "memory_mb", "others")  # medians; the rest is the same in every round
COLUMNS = ("scene", "engine", "version", "flags", "machine", "date", "rounds", "threads", "steps", "bodies", "joints",
           *MEASURED, "sink_m", "top_m", "drift_m", "moved", "lost", "overlap_m", "speed_m_s", "joint_error_m",
           "asleep")


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/compare", description=__doc__.split("\n\n")[0])
    parser.add_argument("--box3d", metavar="DIR", help="sources of Box3D, with libbox3d built inside")
    parser.add_argument("--jolt", metavar="DIR", help="sources of Jolt, with libJolt built inside as Distribution")
    parser.add_argument("--engine", metavar="NAMES", help=f"some of {','.join(ENGINES)}; usually all there are")
    parser.add_argument("--scene", metavar="NAMES", help="separated by commas; usually all")
    parser.add_argument("--sheets", action="store_true", help="cloth in feder and Bullet, at equal worst strain")
    parser.add_argument("--boxes", action="store_true", help="broad phases of feder and Bullet, on the same boxes")
    parser.add_argument("--threads", metavar="N,N", default="1,2", help="usually 1,2 (Bullet has one)")
    parser.add_argument("--steps", type=int, default=0, help="of every scene; usually each its own number")
    parser.add_argument("--rounds", type=int, default=3, help="usually 3")
    parser.add_argument("--out", metavar="FILE", type=pathlib.Path, help="writes its rows there alone")
    options = parser.parse_args()
    try:
        options.threads = [int(n) for n in options.threads.split(",")]
    except ValueError:
        parser.error("--threads wants numbers, such as 1,2")
    if options.rounds < 1 or options.steps < 0 or min(options.threads) < 1:
        parser.error("rounds and threads count from 1, steps from 0")
    return options


def call(*command):
    """What it prints; ends with its output when it fails."""
    out = subprocess.run([str(word) for word in command], capture_output=True, text=True, cwd=ROOT, check=False)
    if out.returncode:
        sys.exit(f"compare: {' '.join(map(str, command))} failed:\n{out.stdout[-4000:]}{out.stderr[-4000:]}")
    return out.stdout


def alone():
    """A lock, to be kept: two runs would build over each other, and each would be the other's busy machine."""
    WORK.mkdir(parents=True, exist_ok=True)
    lock = open(WORK / "lock", "w")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        sys.exit(f"compare: another one runs here ({WORK}); wait for its end")
    return lock


def build(options):
    """The programs of the engines that are there, by name: bodies, or sheets."""
    print("compare: building", file=sys.stderr)
    call("cmake", "-S", ROOT, "-B", WORK / "feder", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DFEDER_LUA=OFF",
         "-DFEDER_PROGRAM=OFF", "-DFEDER_TESTS=OFF", "-DFEDER_PCH=ON", f"-DFEDER_WITHOUT={WITHOUT}")
    call("cmake", "--build", WORK / "feder")
    call("cmake", "--install", WORK / "feder", "--prefix", WORK / "prefix")
    folders = {name: pathlib.Path(folder).resolve() if folder else ""
               for name, folder in (("BOX3D", options.box3d), ("JOLT", options.jolt))}
    call("cmake", "-S", HERE, "-B", WORK / "programs", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
         f"-DFEDER_PREFIX={WORK / 'prefix'}", f"-DFEDER_BUILD={WORK / 'feder'}", *(f"-D{name}={folder}" for name, folder in folders.items()))
    call("cmake", "--build", WORK / "programs")
    kind, names = ("sheet", "sheets.txt") if options.sheets else ("rival", "engines.txt")
    there = (WORK / "programs" / names).read_text().split()
    found = {name: WORK / "programs" / f"{kind}_{name}" for name in ENGINES if name in there}
    wanted = options.engine.split(",") if options.engine else list(found)
    for name in wanted:
        if name not in found:
            sys.exit(f"compare: no engine {name} here; there are {', '.join(found)} (--box3d DIR, --jolt DIR)")
    return {name: found[name] for name in wanted}


def versions(options):
    """(version, flags) of each engine, for the rows."""
    def commit(folder):
        out = subprocess.run(["git", "-C", str(folder), "rev-parse", "--short=7", "HEAD"], capture_output=True,
                             text=True, check=False)
        return out.stdout.strip() or "unknown"

    def cached(folder, library):
        """CMake's cache beside the library that was linked."""
        linked = re.search(rf"\S*{library}\.(a|so)", (WORK / "programs/build.ninja").read_text())
        text = (pathlib.Path(linked[0]).parent / "CMakeCache.txt") if linked else None
        while text and not text.is_file() and text.parent != pathlib.Path(folder).resolve().parent:
            text = text.parent.parent / "CMakeCache.txt"
        return dict(re.findall(r"^(\w+):\w+=(.*)$", text.read_text(), re.M)) if text and text.is_file() else {}

    def wide(disabled=False):
        """The instructions that every processor of this kind has."""
        x86 = platform.machine() in ("x86_64", "AMD64")
        return "plain" if disabled else "SSE2" if x86 else "NEON"

    avx2 = pathlib.Path("/proc/cpuinfo").is_file() and " avx2" in pathlib.Path("/proc/cpuinfo").read_text()
    found = {"feder": (commit(ROOT), "Release, " + ("AVX2 at run time" if avx2 else wide()))}
    if subprocess.run(["pkg-config", "--exists", "bullet"], check=False).returncode == 0:
        found["bullet"] = call("pkg-config", "--modversion", "bullet").strip(), "Debian's package"
    if options.box3d:
        cache = cached(options.box3d, "libbox3d")
        lanes = wide(cache.get("BOX3D_DISABLE_SIMD") == "ON")
        found["box3d"] = commit(options.box3d), f"{cache.get('CMAKE_BUILD_TYPE')}, {lanes}"
    if options.jolt:
        cache = cached(options.jolt, "libJolt")
        words = [cache.get("CMAKE_BUILD_TYPE", "")]
        words += [name.upper().replace("USE_", "") for name in ("USE_AVX512", "USE_AVX2") if cache.get(name) == "ON"]
        words += ["LTO"] if cache.get("INTERPROCEDURAL_OPTIMIZATION") == "ON" else []
        found["jolt"] = commit(options.jolt), ", ".join(words)
    return found


def processor_times():
    """Of the machine and of the programs that this one has run: s, and all there was of it."""
    stat = pathlib.Path("/proc/stat")
    ticks = [int(n) for n in stat.read_text().split("\n")[0].split()[1:9]] if stat.is_file() else [0] * 8
    own = resource.getrusage(resource.RUSAGE_CHILDREN)
    second = os.sysconf("SC_CLK_TCK")
    return (sum(ticks) - ticks[3] - ticks[4]) / second, own.ru_utime + own.ru_stime, sum(ticks) / second


def parse(text):
    """A program's line: printf writes nan and inf for a state that is not finite, Python's JSON NaN and Infinity."""
    return json.loads(re.sub(r"(: -?)inf\b", r"\1Infinity", re.sub(r": -?nan\b", ": NaN", text)))


def run(program, *words):
    """What the program prints, and the share of others; None when it fails."""
    before = processor_times()
    words = [str(word) for word in words]
    out = subprocess.run([program, *words], capture_output=True, text=True, check=False)
    busy, own, whole = (now - then for now, then in zip(processor_times(), before))
    if out.returncode:
        print(f"compare: {program.name} {words[0]} ended with {out.returncode}: {out.stderr.strip()}", file=sys.stderr)
        return None
    if out.stderr.strip():
        print(f"compare: {out.stderr.strip()}", file=sys.stderr)
    return {**parse(out.stdout), "others": max(busy - own, 0) / max(whole, 1e-9)}


def measure(programs, scenes, options):
    """Medians over the rounds: rows by (scene, engine, threads)."""
    runs = {}
    log = WORK / "runs.jsonl"  # each run, for those who end it early
    log.write_text("")
    for turn in range(options.rounds):
        for scene in scenes:
            order = list(programs)
            order = order[turn % len(order):] + order[:turn % len(order)]  # another one is first in each round
            for threads in options.threads:
                for engine in order:
                    if engine == "bullet" and threads > 1:
                        continue
                    print(f"\rround {turn + 1} of {options.rounds}: {scene}, {engine}, {threads} threads".ljust(79),
                          end="", file=sys.stderr, flush=True)
                    found = run(programs[engine], scene, options.steps, threads)
                    if found:
                        runs.setdefault((scene, engine, threads), []).append(found)
                        with open(log, "a") as file:
                            file.write(json.dumps(found) + "\n")
    print(file=sys.stderr)
    rows = {}
    for key, found in runs.items():
        found = [r for r in found if r["others"] <= QUIET] or found
        rows[key] = {**found[0], "rounds": len(found)}
        for column in MEASURED:
            rows[key][column] = statistics.median(r[column] for r in found)
    return rows


def as_csv(rows, options):
    about = versions(options)
    machine = f"{os.cpu_count()} cores {platform.machine()}"
    for row in rows.values():
        row["version"], row["flags"] = about[row["engine"]]
        row["machine"], row["date"] = machine, datetime.date.today().isoformat()
    return [{column: f"{row[column]:.4g}" if isinstance(row[column], float) else row[column] for column in COLUMNS}
            for row in rows.values()]


def stored_rows():
    if not STORED.is_file():
        return []
    with open(STORED, newline="") as file:
        return list(csv.DictReader(file))


def write(rows, options):
    """To options.out alone, or in place of the stored rows of these scenes, if nothing is lost by it."""
    new, old = as_csv(rows, options), stored_rows()
    scenes = {row["scene"] for row in new}
    name = lambda row: (row["scene"], row["engine"], str(row["threads"]), str(row["steps"]))
    lost = {name(row) for row in old if row["scene"] in scenes} - {name(row) for row in new}
    target = options.out or (WORK / "rivals.csv" if lost or options.steps else STORED)
    if target == STORED:
        order = [line.split()[0] for line in call(WORK / "programs/rival_feder", "--list").splitlines()]
        new = sorted(new + [row for row in old if row["scene"] not in scenes],
                     key=lambda row: (order.index(row["scene"]), ENGINES.index(row["engine"]), int(row["threads"])))
    target.parent.mkdir(parents=True, exist_ok=True)
    with open(target, "w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(new)
    print(f"rows are in {target}")


def main():
    options = arguments()
    lock = alone()
    programs = build(options)
    if options.boxes:
        if not (WORK / "programs/boxes").is_file():
            sys.exit("compare: --boxes needs Bullet (libbullet-dev)")
        return boxes.main(WORK / "programs/boxes", options, call, versions(options))
    if options.sheets:
        return sheets.main(programs, options, run, versions(options))
    all_scenes = [line.split()[0] for line in call(next(iter(programs.values())), "--list").splitlines()]
    scenes = options.scene.split(",") if options.scene else all_scenes
    for scene in scenes:
        if scene not in all_scenes:
            sys.exit(f"compare: no scene {scene}; there are {', '.join(all_scenes)}")
    rows = measure(programs, scenes, options)
    if not rows:
        return 1
    aims.print_all(rows)
    disturbed = sum(r["others"] > QUIET for r in rows.values())
    if disturbed:
        print(f"other processes took more than {100 * QUIET:.0f} % of the machine in {disturbed} of {len(rows)} rows: "
              "their figures of several threads say little\n")
    write(rows, options)
    lock.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
