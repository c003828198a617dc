#!/usr/bin/env python3
"""Commands that a signal ends: SIGINT or SIGTERM at random moments, each in a process of its own. What is left must be
whole and readable, hold all that had been said, and nothing else may lie about; the status is 130 or 143.

  interrupts.py FEDER [--moments N] [--seed S]
"""
import argparse
import csv
import json
import pathlib
import random
import re
import signal
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[2]
LATEST = 0.7  # s after the start of a command


class Wrong(Exception):
    pass


def need(holds, what):
    if not holds:
        raise Wrong(what)


def table(file):
    rows = list(csv.reader(file.read_text().splitlines()))
    need(all(len(r) == len(rows[0]) for r in rows), f"{file.name}: rows of different lengths")
    return rows[1:]


def said(out, words):
    found = re.search(words, out)
    return int(found.group(1)) if found else 0


def page(file):
    need(file.read_text().rstrip().endswith("</html>"), f"{file.name} is cut off")


def gif_frames(data):
    """Of a whole file: header, then blocks up to the trailer at its very end."""
    at, frames = 13 + (3 << (data[10] & 7) + 1 if data[10] & 0x80 else 0), 0
    while data[at] != 0x3B:
        if data[at] == 0x2C:
            frames += 1
            at += 11 + (3 << (data[at + 9] & 7) + 1 if data[at + 9] & 0x80 else 0)
        else:
            at += 2
        while data[at]:
            at += data[at] + 1
        at += 1
    need(at == len(data) - 1, "the GIF goes on behind its end")
    return frames


def check_run(folder, out):
    summary = json.loads(out)
    need(summary["interrupted"], "the summary does not say that it was interrupted")
    rows = table(folder / "out.csv")
    need(len(rows) == summary["steps"] + 1, f"{len(rows)} rows of {summary['steps']} steps")
    replay = subprocess.run([sys.argv[1], "replay", "out.rec", "--json"], cwd=folder, capture_output=True, text=True,
                            check=False)
    need(replay.returncode == 0, f"the recording: {replay.stderr}")
    world = json.loads(replay.stdout)["worlds"][0]
    need(world["hash"] == summary["hash"], "the recording ends in another state")
    return f"{len(rows)} rows and a recording of {world['steps']} steps"


def check_study(folder, out):
    log = folder / "out" / "points.jsonl"
    lines = log.read_text().splitlines()[1:] if log.exists() else []
    kept = sorted(json.loads(line)["point"]["index"] for line in lines)
    if kept or (folder / "out" / "report.json").exists():
        report = json.loads((folder / "out" / "report.json").read_text())
        need(sorted(p["index"] for p in report["points"]) == kept, "report.json has other points than points.jsonl")
        need(len(table(folder / "out" / "points.csv")) == len(kept), "points.csv has other points")
        page(folder / "out" / "index.html")
    return f"{len(kept)} points"


def check_stability(folder, out):
    if not (folder / "out").exists():
        return "no cells"
    cells = json.loads((folder / "out" / "stability.json").read_text())["rows"]
    need(len(table(folder / "out" / "cells.csv")) == len(cells), "cells.csv has other cells than stability.json")
    page(folder / "out" / "index.html")
    return f"{len(cells)} cells"


def check_gif(folder, out):
    frames = said(out, r"out\.gif, (\d+) frames")
    there = folder / "out.gif"
    need(there.exists() == (frames > 0), f"{frames} frames were said, a file is there: {there.exists()}")
    if frames:
        need(gif_frames(there.read_bytes()) == frames, f"not the {frames} frames that were said")
    return f"{frames} frames"


def check_frames(folder, out):
    pictures = list((folder / "out").glob("*")) if (folder / "out").exists() else []
    need(all(p.read_bytes().endswith(b"IEND\xaeB`\x82") for p in pictures), "a picture is cut off")
    need(len(pictures) == said(out, r"out/, (\d+) frames"), f"{len(pictures)} pictures, but: {out}")
    return f"{len(pictures)} pictures"


def check_gltf(folder, out):
    samples = said(out, r"out\.gltf, (\d+) samples")
    if samples:
        scene = json.loads((folder / "out.gltf").read_text())
        if scene.get("animations"):
            times = scene["accessors"][scene["animations"][0]["samplers"][0]["input"]]
            need(times["count"] in (samples, samples + 1), f"{times['count']} times of {samples} samples")
    return f"{samples} samples"


def check_series(folder, out):
    samples = said(out, r"out\.vtp, (\d+) samples")
    listed = []
    if (folder / "out.pvd").exists():
        listed = [e.get("file") for e in xml.etree.ElementTree.parse(folder / "out.pvd").iter("DataSet")]
    need(len(listed) == samples and sorted(listed) == sorted(p.name for p in folder.glob("*.vtp")),
         f"{len(listed)} files are listed, {samples} were said")
    for name in listed:
        xml.etree.ElementTree.parse(folder / name)
    return f"{samples} files"


def check_test(folder, out):
    passed = len(re.findall(r"^ok ", out, re.M))
    need(said(out, r"(\d+) passed") == passed, f"{passed} tests passed, but: {out[-60:]}")
    if (folder / "out.xml").exists():
        cases = list(xml.etree.ElementTree.parse(folder / "out.xml").iter("testcase"))
        need(len(cases) >= passed, "tests are missing in the XML file")
    else:
        need(passed == 0, "no XML file")
    return f"{passed} tests"


def check_bench(folder, out):
    result = json.loads(out) if out else {}
    need(not result or result["ms_per_step"]["min"] > 0, "no minimum")
    return f"{result.get('runs', 0)} runs" if result else "nothing"


TOWER, POOL = ROOT / "scenes/rigid/tower.lua", ROOT / "scenes/fluid/glass.lua"
SMALL = ["--size", "64x48", "--seconds", "600"]
COMMANDS = [
    (["run", TOWER, "--seconds", "1e6", "--json", "--csv", "out.csv", "--track", "crate*", "--record", "out.rec"],
     check_run),
    (["study", "oscillator", "--out", "out"], check_study),
    (["study", ROOT / "scenes/study/hydrostatic.lua", "--repeat", "0", "--out", "out"], check_study),
    (["stability", "swinging_chain", "--out", "out"], check_stability),
    (["render", TOWER, "-o", "out.gif", *SMALL], check_gif),
    (["render", TOWER, "-o", "out/", *SMALL], check_frames),
    (["export", ROOT / "scenes/rigid/mixed_pile.lua", "-o", "out.gltf", "--seconds", "600"], check_gltf),
    (["export", POOL, "-o", "out.vtp", "--every", "0.02", "--seconds", "600"], check_series),
    (["test", ROOT / "scenes/rigid", ROOT / "scenes/springs", "--junit", "out.xml"], check_test),
    (["bench", TOWER, "--json", "--runs", "10000"], check_bench),
]


def moment(feder, words, check, delay, number):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        child = subprocess.Popen([feder, *map(str, words)], cwd=folder, text=True, stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, stdin=subprocess.DEVNULL)
        time.sleep(delay)
        child.send_signal(number)
        try:
            out, err = child.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            child.kill()
            child.communicate()
            raise Wrong("no end 20 s after the signal") from None
        # before the program has begun its work the signal kills it: nothing may be there then
        if child.returncode == -number:
            need(not out and not any(folder.iterdir()), "killed, but something had been done")
            return "not begun"
        if "OpenGL" in err and child.returncode == 1:
            return "skipped: no OpenGL"
        need(child.returncode == {signal.SIGINT: 130, signal.SIGTERM: 143}[number],
             f"status {child.returncode}: {err[-200:]}")
        need("interrupted" in err, f"stderr says nothing of it: {err[-200:]}")
        left = [p.name for p in folder.rglob("*.part*")]
        need(not left, f"left behind: {left}")
        if not out and not any(folder.iterdir()):
            return "nothing done yet"
        return check(folder, out)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("feder")
    parser.add_argument("--moments", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    feder = sys.argv[1] = str(pathlib.Path(options.feder).resolve())
    chance = random.Random(options.seed)
    bad = 0
    for k in range(options.moments):
        words, check = COMMANDS[k % len(COMMANDS)]
        number = chance.choice([signal.SIGINT, signal.SIGTERM])
        delay = chance.uniform(0, LATEST)
        how = f"{number.name} after {delay:.3f} s: feder {words[0]} {pathlib.Path(words[1]).name}"
        try:
            print(f"{how}: {moment(feder, words, check, delay, number)}")
        except (Wrong, OSError, ValueError, KeyError, IndexError, xml.etree.ElementTree.ParseError) as e:
            bad += 1
            print(f"{how}: WRONG: {type(e).__name__}: {e}")
    print(f"interrupts: {options.moments - bad} of {options.moments} moments left whole results")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
