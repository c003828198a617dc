#!/usr/bin/env python3
"""The tables of the README that commands print: made again and compared.

  figures.py FEDER [NAME...]            compare every block (or those named) of README.md with what its commands print
  figures.py --renew FEDER [NAME...]    write the blocks anew, with their pictures in tests/golden/pictures

A block stands between "<!-- figures: NAME -->" and "<!-- end -->". Errors and counts are compared exactly, and no block
holds a time: run times differ from machine to machine. Rows about engines that cannot be run here come from
tests/bench/rivals.csv. Exit status 1 when a block differs or is missing.
"""
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
PICTURES = "tests/golden/pictures"
FLUIDS = (("hydrostatic", "pressure rho g (H - z)"), ("dam_break", "Martin & Moyce, with the delay of their diaphragm"),
          ("draught", "Archimedes"), ("poiseuille", "start-up series"), ("droplet", "Lamb's half period"))
# problem, small steps, reference
CLOTHS = (("hanging_sheet", 16, "closed form"), ("catenary", 16, "closed form"), ("cantilever", 32, "elastica"),
          ("drape", 8, "self-refined run"))


def study(feder, *words):
    out = subprocess.run([feder, "study", *words, "--repeat", "0"], capture_output=True, text=True, cwd=ROOT, check=False)
    if out.returncode != 0:
        sys.exit(f"figures: feder study {' '.join(words)} ended with {out.returncode}: {out.stderr.strip()}")
    return out.stdout


def picked(feder, name, picture, *words):
    """The picture's link and the table of the cheapest methods."""
    with tempfile.TemporaryDirectory() as folder:
        study(feder, *words, "--quiet", "--out", folder, "--markdown", folder + "/pick.md", "--picture", f"{PICTURES}/{picture}")
        if name in renewed:
            (ROOT / PICTURES / picture).write_bytes(pathlib.Path(folder, "error_vs_work.svg").read_bytes())
        return pathlib.Path(folder, "pick.md").read_text().strip()


def percent(value):
    """2.04 -> "2.0 %", 3e-6 -> "3e-6"."""
    if value is None:
        return "-"
    return f"{100 * value:.2g} %" if value >= 1e-4 else f"{value:.0e}".replace("e-0", "e-")


def errors(feder, words, methods):
    """err_end of each method at the one rung asked for; a star where the reference is no surer than that."""
    report = json.loads(study(feder, *words, "--json"))
    floor = report["problem"]["reference"]["floor"]
    out = []
    for method in methods:
        point = next(p for p in report["points"] if p["method"] == method)
        if point["status"] not in ("ok", "slow"):
            out.append(point["status"])
        else:
            out.append(percent(point["err_end"]) + (" *" if point["err_end"] < floor else ""))
    return out


def fluids(feder):
    rows = ["| `feder study` | reference | `pbf` | `wcsph` |", "|---|---|---|---|"]
    for problem, reference in FLUIDS:
        found = errors(feder, [problem, "--ladder", "substeps:4"], ("pbf", "wcsph"))
        rows.append(f"| `{problem}` | {reference} | {found[0]} | {found[1]} |")
    return "\n".join(rows)


def cloths(feder):
    rows = ["| `feder study` | reference | `xpbd` | `mass_spring` |", "|---|---|---|---|"]
    for problem, steps, reference in CLOTHS:
        found = errors(feder, [problem, "--ladder", f"substeps:{steps}"], ("xpbd", "mass_spring"))
        rows.append(f"| `{problem}`, {steps} small steps | {reference} | {found[0]} | {found[1]} |")
    return "\n".join(rows) + "\n\n\\* the reference is no surer than that"


def rivals(_):
    rows = ["| scene | beside | feder's time over its | end state of feder (the other's) |", "|---|---|---|---|"]
    with open(ROOT / "tests/bench/rivals.csv", newline="") as file:
        for r in csv.DictReader(file):
            rows.append(f"| {r['scene']} | {r['engine']} {r['commit']}, {r['flags']} | {float(r['ratio']):.2f} | {r['end_state']} |")
    return "\n".join(rows)


BLOCKS = {
    "rivals": rivals,
    "stiff_chain": lambda f: picked(f, "stiff_chain", "stiff_chain.svg", "swinging_chain", "--set", "stiffness=1e8"),
    "orbit": lambda f: picked(f, "orbit", "orbit.svg", "kepler", "--set", "e=0.9"),
    "fluids": fluids,
    "cloths": cloths,
}
renewed = set()


def main(arguments):
    words = [a for a in arguments if a != "--renew"]
    names = words[1:] or list(BLOCKS)
    if not words or any(n not in BLOCKS for n in names):
        print(__doc__ + "\nBlocks: " + ", ".join(BLOCKS), file=sys.stderr)
        return 2
    if "--renew" in arguments:
        renewed.update(names)
    feder = str(pathlib.Path(words[0]).resolve())
    text, bad = README.read_text(), 0
    for name in names:
        found = re.search(rf"(<!-- figures: {name} -->\n\n)(.*?)(\n\n<!-- end -->)", text, re.S)
        if not found:
            print(f"figures: README.md has no block '{name}'")
            bad += 1
            continue
        now = BLOCKS[name](feder)
        if now == found[2]:
            print(f"figures: {name}: as printed")
        elif name in renewed:
            text = text[:found.start(2)] + now + text[found.end(2):]
            print(f"figures: {name}: renewed")
        else:
            bad += 1
            print(f"figures: {name}: README.md says\n{found[2]}\nits commands print\n{now}")
    if renewed:
        README.write_text(text)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
