#!/usr/bin/env python3
"""The state hash of every shipped scene, and of one scene per pair of systems, with every solver of its kind.

  golden.py FEDER REAL            compare with tests/golden/hashes.txt (REAL: float or double)
  golden.py --late FEDER REAL     those that the first leaves out
  golden.py --renew FEDER REAL    store the hashes of this build instead: one commit with the change that moved them,
                                  whose message says why

A line of the file is "REAL scene [options] steps hash". Hashes are taken after 240 steps at the scene's own settings,
and after 60, which is late where 240 steps are not: they say when a scene began to differ. They are the same for gcc
and clang, -O1 and -O3, 1, 2 and 4 threads (scripts/check/determinism.py). Lines of other checks in the file
(tests/rigid/test_determinism.cpp) stay as they are. Exit status 1 when a line differs or is missing, on either side.
"""
import concurrent.futures
import json
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILE = ROOT / "tests" / "golden" / "hashes.txt"
STEPS = (60, 240)
PAIR = "tests/golden/pair.lua"
GROUPS = "tests/golden/groups.lua"  # cloths that do not meet
KINDS = {"rigid": ["", "--world rigid.solver=impulse"], "net": [""],
         "cloth": [f"--set cloth={name}" for name in ("xpbd", "mass_spring", "vbd", "implicit")], "rope": [""], "soft": [""],
         "fluid": ["--set fluid=pbf", "--set fluid=wcsph", "--set fluid=dfsph"]}
# scenes that take long at their own size run smaller
SMALLER = {"scenes/cloth/fold.lua": "--set rows=20", "scenes/cloth/tablecloth.lua": "--set rows=21",
           "scenes/cloth/curtain_ball.lua": "--set rows=17", "scenes/fluid/floating_crates.lua": "--set spacing=0.06",
           "scenes/fluid/glass.lua": "--set spacing=0.012", "scenes/study/siphon.lua": "--set particles=40",
           "scenes/study/honey_fold.lua": "--set particles=40", "scenes/study/droplet_3d.lua": "--set particles=14",
           "scenes/rigid/wall.lua": "--set rows=8 --set length=12", "scenes/rigid/columns.lua": "--set side=2",
           "scenes/rigid/mixed_pile.lua": "--set count=40", "scenes/rigid/stones.lua": "--set count=40",
           "scenes/rigid/quarry.lua": "--set cuts=12"}
# two thirds of the time of all: scripts/test looks at their first 60 steps alone, scripts/test --all at 240
LONG = ("scenes/rigid/ragdolls.lua --world rigid.solver=impulse", "scenes/rigid/joint_grid.lua --world rigid.solver=impulse",
        "scenes/study/added_mass.lua", "scenes/fluid/floating_crates.lua --set spacing=0.06",
        "scenes/cookbook/sail_boat.lua", "scenes/lessons/09_fluid.lua", "scenes/study/taylor_green.lua",
        "scenes/study/u_tube.lua", "scenes/rigid/wall.lua --set rows=8 --set length=12 --world rigid.solver=impulse",
        "scenes/rigid/pyramid.lua --world rigid.solver=impulse", "scenes/fluid/bottle.lua",
        "scenes/fluid/rain_on_pond.lua", "scenes/fluid/fountain.lua", "scenes/fluid/dam_break.lua",
        "scenes/fluid/honey.lua", "scenes/fluid/sluice.lua", "scenes/fluid/wave_tank.lua", "scenes/cloth/fold.lua --set rows=20",
        "scenes/study/honey_fold.lua --set particles=40", "scenes/study/siphon.lua --set particles=40",
        *(f"{PAIR} --set below=cloth --set above=fluid --set cloth=implicit --set fluid={fluid}"
          for fluid in ("pbf", "wcsph", "dfsph")))


def integrators():
    """Of pair.lua's own list, so that it stands in one place."""
    listed = re.search(r'"integrator".*?choices = \{(.*?)\}', (ROOT / PAIR).read_text(), re.S).group(1)
    return re.findall(r'"(\w+)"', listed)


def time_step(text):
    dt = re.search(r"\bdt\s*[=:]\s*(?:1\s*/\s*)([0-9]+)", text)
    return 1 / int(dt.group(1)) if dt else 1 / 60


def cases():
    """(scene, options, time step) of every line."""
    for path in sorted((ROOT / "scenes").rglob("*")):
        if path.suffix not in (".lua", ".yaml"):
            continue
        text = path.read_text()
        if path.suffix == ".lua" and "feder.scene" not in text:
            continue
        scene = str(path.relative_to(ROOT))
        yield scene, SMALLER.get(scene, ""), time_step(text)
        if path.parent.name == "rigid":
            yield scene, f"{SMALLER.get(scene, '')} --world rigid.solver=impulse".strip(), time_step(text)
    for a, below in enumerate(KINDS):
        for above in list(KINDS)[a:]:
            if below == above:
                solvers = set(KINDS[below])
            else:
                solvers = {f"{x} {y}".strip() for x in KINDS[below] for y in KINDS[above]}
            for solver in sorted(solvers):
                yield PAIR, f"--set below={below} --set above={above} {solver}".strip(), 1 / 60
    for below in ("rigid", "soft"):
        for soft in ("vbd", "vbd --set elasticity=stvk", "implicit", "implicit --set elasticity=corotated"):
            yield PAIR, f"--set below={below} --set above=soft --set soft={soft}", 1 / 60
    yield GROUPS, "--set sheets=3", 1 / 60
    for integrator in integrators()[:1] + integrators()[2:]:
        yield PAIR, f"--set below=net --set above=rigid --set integrator={integrator}", 1 / 60


def run(feder, scene, options, seconds):
    out = subprocess.run([feder, "run", scene, "--json", "--quiet", "--seconds", repr(seconds), *options.split()],
                         capture_output=True, text=True, cwd=ROOT, check=False)
    try:
        result = json.loads(out.stdout)
    except ValueError:
        return None, "failed: " + (out.stderr.strip().splitlines() or ["?"])[-1]
    return result["steps"], result["hash"]


def is_late(key):
    """key: "REAL scene [options] steps"."""
    words = key.split()
    return (int(words[-1]) == STEPS[-1]) == (" ".join(words[1:-1]) in LONG)


def measure(feder, real, wanted):
    """The hashes of those keys that are wanted."""
    jobs = [(scene, options, steps, dt) for scene, options, dt in cases() for steps in STEPS
            if wanted(f"{real} {scene} {options} {steps}")]

    def one(job):
        scene, options, steps, dt = job
        ran, value = run(feder, scene, options, steps * dt)
        if ran not in (None, steps):
            value = f"ran {ran} steps"
        return " ".join(f"{real} {scene} {options} {steps}".split()), value.replace(" ", "_")

    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        return dict(pool.map(one, jobs))


def mine(line, real):
    return line.startswith((f"{real} scenes/", f"{real} {PAIR}", f"{real} {GROUPS}"))


def main(arguments):
    words = [a for a in arguments if a not in ("--renew", "--late")]
    if len(words) != 2 or words[1] not in ("float", "double"):
        print(__doc__, file=sys.stderr)
        return 2
    feder, real = str(pathlib.Path(words[0]).resolve()), words[1]
    if "--renew" in arguments:
        wanted = bool
    elif "--late" in arguments:
        wanted = is_late
    else:
        def wanted(key):
            return not is_late(key)
    now = measure(feder, real, wanted)
    broken = [f"{key}: {value}" for key, value in now.items() if not re.fullmatch("[0-9a-f]{16}", value)]
    for line in broken:
        print(f"golden: {line}")
    lines = FILE.read_text().splitlines()
    if "--renew" in arguments:
        if broken:
            return 1
        kept = [line for line in lines if not mine(line, real)]
        scenes = [line for line in kept if mine(line, "float") or mine(line, "double")]
        scenes += [f"{key} {value}" for key, value in now.items()]
        others = [line for line in kept if line not in scenes]
        FILE.write_text("\n".join(others + sorted(scenes, key=lambda s: (s.startswith("double"), s))) + "\n")
        print(f"golden: stored {len(now)} hashes of {real}")
        return 0
    stored = dict(line.rsplit(" ", 1) for line in lines if mine(line, real))
    unknown = [scene for scene in LONG if f"{real} {scene} {STEPS[-1]}" not in stored]
    for scene in unknown:
        print(f"golden: {scene} takes long, and has no hash")
    stored = {key: value for key, value in stored.items() if wanted(key)}
    bad = len(unknown)
    for key in sorted(set(now) | set(stored)):
        if now.get(key) != stored.get(key):
            bad += 1
            print(f"golden: {key}: stored {stored.get(key, 'nothing')}, is {now.get(key, 'not run')}")
    print(f"golden: {len(now)} hashes of {real}, {bad} differ")
    return 1 if bad or broken else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
