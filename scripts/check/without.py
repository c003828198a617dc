#!/usr/bin/env python3
"""What FEDER_WITHOUT does, configure runs only: without.py [CMAKE].

Each module alone, each family's default alone, each family whole, and three misspellings: either the build is
configured and no link line wants a library that is not built, or CMake stops with the line that says why."""
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
# who is named when a module that others need is left out; the others can be
NEEDED = {"base": "bounds", "geom": "state", "linear": "integrate", "state": "step", "step": "world", "integrate": "springs",
          "forces": "world", "collide": "couple", "contact": "cloth", "broad": "collide", "narrow": "collide", "bounds": "geom", "constrain": "rigid",
          "sph": "fluid", "neighbors": "fluid"}
FREE = ["springs", "rigid", "cloth", "rope", "soft", "fluid", "couple", "world", "study", "lua", "yaml", "meshes", "report",
        "view",
        "live", "window", "states", "cli"]
DEFAULTS = ["broad.tree", "rigid.soft_step", "integrate.symplectic_euler", "cloth.xpbd", "fluid.dfsph", "sph.wendland",
            "neighbors.uniform_grid"]
MISSPELT = {"sprngs": "springs", "broad.sweep_prun": "broad.sweep_prune", "rigid.softstep": "rigid.soft_step"}


def variants(module):
    text = (ROOT / "runtime" / module / "CMakeLists.txt").read_text()
    found = re.findall(rf"^feder_(?:variant\({module} |kernel\()(\w+)", text, re.M)
    found += [f"{a}_{b}" for a, b in re.findall(r"^feder_pair\((\w+) (\w+)\)", text, re.M)]
    return [f"{module}.{v}" for v in found]


def configure(cmake, build, left_out):
    out = subprocess.run([cmake, "-S", ROOT, "-B", build, "-G", "Ninja", "-DFEDER_TESTS=OFF",
                          "-DFEDER_WITHOUT=" + ";".join(left_out)], capture_output=True, text=True, check=False)
    return out.returncode, " ".join((out.stdout + out.stderr).split())


def unresolved(build):
    return sorted(set(re.findall(r"-lfeder_\w+", (pathlib.Path(build) / "build.ninja").read_text())))


def main(cmake="cmake"):
    cases = [([m], user, f"'{m}' cannot be left out") for m, user in NEEDED.items()]
    cases += [([m], None, "") for m in FREE + DEFAULTS]
    families = ["broad", "narrow", "forces", "constrain", "geom"]
    cases += [(variants(f), None, "") for f in families]
    cases += [([wrong], right, "did you mean") for wrong, right in MISSPELT.items()]
    cases += [(["quux"], "nothing is called 'quux'", "")]
    bad = 0
    with tempfile.TemporaryDirectory() as build:
        for left_out, *expected in cases:
            status, text = configure(cmake, build, left_out)
            fails = expected[0] is not None
            wrong = ""
            if fails != (status != 0):
                wrong = f"exit status {status}: {text[-600:]}"
            elif fails and not all(e in text for e in expected):
                wrong = f"expected {expected} in: {text[-600:]}"
            elif not fails and unresolved(build):
                wrong = "links what is not built: " + " ".join(unresolved(build))
            if wrong:
                bad += 1
                print(f"without {';'.join(left_out)[:80]}: {wrong}")
    print(f"without: {len(cases)} configure runs, {bad} wrong")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
