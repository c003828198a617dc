#!/usr/bin/env python3
"""The figures of the documents that commands print: made again and compared.

  figures.py FEDER [NAME...]            compare every block (or those named) with what its commands print
  figures.py --renew FEDER [NAME...]    write the blocks anew, with their pictures in tests/golden/pictures
  figures.py --list                     the blocks and the documents they stand in

A block stands between "<!-- figures: NAME -->" and "<!-- end -->" in one of DOCUMENTS. Its name says which command made
it: a name that stands in no document, in two, or twice in one is an error, and so is one that no command makes. Errors,
counts and pictures are compared exactly (pictures without the titles of their points, which hold bytes), and no block
holds a time but those stored with their machine and date: run times differ from machine to machine. Rows about engines
that cannot be run here come from tests/bench/rivals.csv and sheets.csv. Exit status 1 when a block differs, is missing
or stands twice.
"""
import csv
import functools
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTS = ("README.md", "runtime/README.md", "scenes/README.md", "bindings/README.md", "tests/README.md")
PICTURES = "tests/golden/pictures"
EVERYTHING = "scenes/mixed/everything.lua"
FLUIDS = (("hydrostatic", "pressure rho g (H - z)"), ("dam_break", "Martin & Moyce, with the delay of their diaphragm"),
          ("draught", "Archimedes"), ("poiseuille", "start-up series"), ("droplet", "Lamb's half period"),
          ("slosh", "period of potential theory"), ("u_tube", "Newton's period"), ("vessels", "level of the volume"),
          ("torricelli", "v^2 = 2 g h"), ("couette", "start-up series"), ("taylor_green", "decay of the energy"),
          ("two_layer", "Lamb's internal wave"), ("added_mass", "g (1 - s) / (s + C)"), ("siphon", "Newton's period"),
          ("droplet_3d", "Lamb's half period"), ("contact_angle", "Young's angle, of a radian"),
          ("honey_fold", "folds of a thin sheet"))
# problem, substeps, reference
CLOTHS = (("hanging_sheet", 16, "closed form"), ("catenary", 16, "closed form"), ("cantilever", 32, "elastica"),
          ("drape", 8, "self-refined run"), ("drum", 4, "modes of a membrane"), ("balloon", 8, "Laplace's law"))
# of rivals.csv and rivals_by_hand.csv, in README.md: what is faster and what is slower, one of each kind
TELLING = (("large_pyramid", "box3d"), ("large_pyramid", "jolt"), ("large_pyramid", "bullet"),
           ("convex_vs_mesh", "jolt"), ("heavy_chains", "box3d"), ("cloth links", "Jolt"), ("pbf", "SPlisHSPlasH"))
ENGINES = {"box3d": "Box3D", "jolt": "Jolt", "bullet": "Bullet"}
QUIET = .05  # of the machine's processor time, taken by other processes
# of the end state of each scene, what tells most: column, its factor, text around the number
TELLS = {"large_pyramid": ("top_m", 1, "top at {:.2f} m"), "pyramid_50": ("top_m", 1, "top at {:.2f} m"),
         "pyramid_200": ("overlap_m", 1e3, "overlap {:.1f} mm"), "many_pyramids": ("overlap_m", 1e3, "overlap {:.1f} mm"),
         "square_pyramid": ("overlap_m", 1e3, "overlap {:.1f} mm"), "wall": ("drift_m", 1e2, "drift {:.1f} cm"),
         "columns": ("moved", 1, "{:.0f} of 500 moved"), "washer": ("overlap_m", 1e3, "overlap {:.0f} of 400 mm"),
         "convex_fall": ("lost", 1, "{:.0f} lost"), "convex_pile": ("lost", 1, "{:.0f} lost"),
         "convex_vs_mesh": ("overlap_m", 1e3, "overlap {:.0f} mm"),
         "joint_grid": ("joint_error_m", 1e3, "joint error {:.1f} mm"),
         "heavy_chains": ("joint_error_m", 1e3, "joint error {:.2g} mm")}
OWNERS = {"h": "object", "buf": "buffer", "c": "connection", "e": "event"}  # words of signatures that are no class


def run(command, *words):
    out = subprocess.run([command, *words], capture_output=True, text=True, cwd=ROOT, check=False)
    if out.returncode != 0:
        sys.exit(f"figures: feder {' '.join(words)} ended with {out.returncode}: {out.stderr.strip() or out.stdout}")
    return out.stdout


def study(feder, *words):
    return run(feder, "study", *words, "--repeat", "0")


def drawing(svg):
    """A picture without the titles of its points."""
    return re.sub(r"<title>.*?</title>", "", svg, flags=re.S)


@functools.cache
def picked(feder, picture, *words):
    """The picture's link ("PICTURE") and the table of the cheapest methods."""
    with tempfile.TemporaryDirectory() as folder:
        study(feder, *words, "--quiet", "--out", folder, "--markdown", folder + "/pick.md", "--picture", "PICTURE")
        svg, kept = pathlib.Path(folder, "error_vs_work.svg").read_text(), ROOT / PICTURES / picture
        text = pathlib.Path(folder, "pick.md").read_text().strip()
        if renewing:
            kept.write_text(svg)
        elif drawing(svg) != drawing(kept.read_text()):
            text += f"\n\n{PICTURES}/{picture} shows something else"
        return text


def linked(text, picture, folder):
    return text.replace("PICTURE", os.path.relpath(ROOT / PICTURES / picture, folder))


def stiff_chain(feder, folder):
    picture = "stiff_chain.svg"
    return linked(picked(feder, picture, "swinging_chain", "--set", "stiffness=1e8"), picture, folder)


def orbit(feder, folder):
    return linked(picked(feder, "orbit.svg", "kepler", "--set", "e=0.9"), "orbit.svg", folder)


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
        point = next((p for p in report["points"] if p["method"] == method), None)
        if not point:
            out.append("-")
        elif point["status"] not in ("ok", "slow"):
            out.append(point["status"])
        else:
            out.append(percent(point["err_end"]) + (" *" if point["err_end"] < floor else ""))
    return out


def fluids(feder, _):
    rows = ["| `feder study` | reference | `pbf` | `wcsph` | `dfsph` |", "|---|---|---|---|---|"]
    for problem, reference in FLUIDS:
        found = errors(feder, [problem, "--ladder", "substeps:4"], ("pbf", "wcsph", "dfsph"))
        rows.append(f"| `{problem}` | {reference} | {' | '.join(found)} |")
    return "\n".join(rows)


def cloths(feder, _):
    rows = ["| `feder study` | reference | `xpbd` | `mass_spring` |", "|---|---|---|---|"]
    for problem, steps, reference in CLOTHS:
        found = errors(feder, [problem, "--ladder", f"substeps:{steps}"], ("xpbd", "mass_spring"))
        rows.append(f"| `{problem}`, {steps} substeps | {reference} | {found[0]} | {found[1]} |")
    return "\n".join(rows) + "\n\n\\* the reference is no surer than that"


def hierarchies(feder, _):
    """Share of false pairs by volume, and tests of volumes by build, per item in all steps."""
    alone = {p["method"]: p for p in json.loads(study(feder, "bounding_volume", "--json"))["points"]}
    points = json.loads(study(feder, "hierarchy", "--json"))["points"]
    tests = {p["method"]: p["force_evals"] for p in points if dict(p["settings"]) == {"leaf": "1"}}
    assert all(p["err_constraint"] == 0 for p in [*alone.values(), *points]), "a pair that touches was missed"
    builds = list(dict.fromkeys(name.split(".")[1] for name in tests))
    rows = [f"| volume | false pairs | {' | '.join(f'`{b}`' for b in builds)} |", "|---" * (2 + len(builds)) + "|"]
    for volume, point in alone.items():
        counts = " | ".join(str(tests[f'{volume}.{b}']) for b in builds)
        rows.append(f"| `{volume}` | {100 * point['err_end']:.0f} % | {counts} |")
    return "\n".join(rows)


def narrow_phases(feder, _):
    """Steps a query, and what a hull keeps, by corners and by how much a pair turns in a query."""
    rows = ["| corners of a hull | `gjk`, 1 rad | 0.01 rad | `voronoi`, 1 rad | 0.1 rad | 0.01 rad | 0.001 rad | kept |",
            "|---|---|---|---|---|---|---|---|"]
    for corners in (8, 32, 128):
        points = json.loads(study(feder, "narrow_phase", "--set", f"vertices={corners}", "--json"))["points"]
        assert all(p["err_constraint"] == 0 and p["err_end"] < 1e-6 and p["rejected"] == 0 for p in points), corners
        steps = {(p["method"], dict(p["settings"])["turn"]): f"{p['force_evals'] / p['steps']:.1f}" for p in points}
        kept = {p["method"]: p["peak_bytes"] for p in points}
        columns = [steps[key] for key in (("gjk", "1"), ("gjk", "0.01"), *(("voronoi", t) for t in ("1", "0.1", "0.01", "0.001")))]
        rows.append(f"| {corners} | {' | '.join(columns)} | {kept['voronoi'] / 16e3:.1f} kB |")
    return "\n".join(rows)


def broad_phases(feder, _):
    """Nodes, boxes and ends looked at by box and step, by arrangement; times of boxes.csv over those of `tree`."""
    methods, rows = [], []
    for arrangement in ("gas", "pile", "city", "huge_and_tiny", "cluster", "line_up", "identical"):
        points = json.loads(study(feder, "broad_phase", "--set", f"arrangement={arrangement}", "--set", "boxes=500",
                                  "--json"))["points"]
        assert all(p["err_constraint"] == 0 and p["err_end"] == 0 for p in points), arrangement
        looked = {(p["method"], dict(p["settings"])["speed"]): p["force_evals"] + p["jac_evals"] + p["rejected"]
                  for p in points}
        methods = list(dict.fromkeys(p["method"] for p in points))
        rows.append(f"| {arrangement} | " + " | ".join(f"{looked[m, '0.003']}, {looked[m, '1']}" for m in methods) + " |")
    lines = [f"| looked at, speed 0.003, 1 | {' | '.join(f'`{m}`' for m in methods)} |",
             "|---" * (1 + len(methods)) + "|", *rows, ""]
    rows = rows_of("boxes.csv")
    kinds = list(dict.fromkeys((r["engine"], r["method"]) for r in rows))
    names = [f"`{m}`" if e == "feder" else f"{ENGINES[e]} {m}" for e, m in kinds]
    lines += [f"| boxes, speed | `tree`, us | {' | '.join(names[1:])} |", "|---" * (1 + len(kinds)) + "|"]
    for where in dict.fromkeys((r["boxes"], r["speed"]) for r in rows):
        ms = {(r["engine"], r["method"]): float(r["step_ms"]) for r in rows if (r["boxes"], r["speed"]) == where}
        ratios = [f"{ms[kind] / ms[kinds[0]]:.2f}" for kind in kinds[1:]]
        lines.append(f"| {where[0]}, {where[1]} | {1e3 * ms[kinds[0]]:.0f} | {' | '.join(ratios)} |")
    r = next(r for r in rows if r["engine"] == "bullet")
    lines += ["", f"Processor time of a step, over that of `tree`; Bullet {r['version']}; "
              f"{r['machine'].replace('_', '-')}, {r['date']}."]
    return "\n".join(lines)


def rows_of(name):
    with open(ROOT / "tests/bench" / name, newline="") as file:
        return list(csv.DictReader(file))


def measured():
    """Rows of rivals.csv by (scene, engine, threads)."""
    return {(r["scene"], r["engine"], r["threads"]): r for r in rows_of("rivals.csv")}


def ratio(rows, scene, engine, threads, column):
    """feder over another engine, as text; none of several threads unless the machine was known to be quiet."""
    ours, its = rows.get((scene, "feder", threads)), rows.get((scene, engine, threads))
    if not ours or not its or (threads != "1" and any(float(r["others"] or 1) > QUIET for r in (ours, its))):
        return "-"
    return f"{float(ours[column]) / float(its[column]):.2f}"


def end_states(rows, scene, engine):
    """feder's and, in brackets, the other's."""
    column, factor, text = TELLS[scene]
    ours, its = (factor * float(rows[scene, name, "1"][column]) for name in ("feder", engine))
    number = re.search(r"{:.*?}", text)[0]
    return f"{text.format(ours)} ({number.format(its)})"


def rivals(_feder, _folder):
    lines, rows = ["| scene | beside | time over its | end state (the other's) |", "|---|---|---|---|"], measured()
    for scene, engine in TELLING:
        if engine in ENGINES:
            time = ratio(rows, scene, engine, "1", "processor_ms")
            lines.append(f"| {scene} | {ENGINES[engine]} | {time} | {end_states(rows, scene, engine)} |")
            continue
        r = next(r for r in rows_of("rivals_by_hand.csv") if r["scene"].startswith(scene) and r["engine"] == engine)
        name = re.split(r" \(|, per| against", r["scene"])[0]
        engine += ", double" if "double" in r["flags"] else ""
        lines.append(f"| {name} | {engine} | {float(r['ratio']):.2f} | {r['end_state']} |")
    return "\n".join(lines)


def sheets(_feder, _folder):
    """sheets.csv: what a hung sheet costs in each engine, and how much it is stretched; feder's first."""
    names = {"feder": "feder", "pbd": "PositionBasedDynamics", **ENGINES}
    rows = rows_of("sheets.csv")
    per_row = {r["side_vertices"]: float(r["row_ns"]) for r in rows if (r["engine"], r["how"]) == ("feder", "default")}
    lines = ["| sheet | engine | constraints, times solved | ms a frame | worst strain | ns a constraint and time | "
             "feder's over it |", "|---|---|---|---|---|---|---|"]
    for r in sorted(rows, key=lambda r: (r["rounds"] == "0", int(r["side_vertices"]))):
        side, count = r["side_vertices"], int(r["links"]) + int(r["bends"])
        engine = f"{names[r['engine']]}, {r['how']}" + (" *" if r["rounds"] == "0" else "")
        ours = per_row.get(side) or max(per_row.values())
        ratio = "" if r["engine"] == "feder" else f"{ours / float(r['row_ns']):.2f}"
        cells = (f"{side} x {side}", engine, f"{count} x {float(r['sweeps']):.0f}", f"{float(r['frame_ms']):.1f}",
                 f"{100 * float(r['worst']):.{1 if float(r['worst']) < .1 else 0}f} %", f"{float(r['row_ns']):.1f}", ratio)
        lines.append(f"| {' | '.join(cells)} |".replace("|  |", "| |"))
    about = "; ".join({f"{names[r['engine']]} {r['version']} ({r['flags']})": None for r in rows})
    dates = " and ".join(sorted({f"{r['machine'].replace('_', '-')}, {r['date']}" for r in rows}))
    busy = ", beside other processes" if any(float(r["others"] or 0) > QUIET for r in rows) else ""
    lines += ["", textwrap.fill(f"{about}; processor time of one thread{busy}; {dates}.", 120),
              "", "\\* by the engine's own program, on such a machine; not solved to feder's strain"]
    return "\n".join(lines)


def rivals_all(_feder, _folder):
    rows = measured()
    lines = ["| scene | beside | time over its | two threads | memory over its | end state of feder (the other's) |",
             "|---|---|---|---|---|---|"]
    for (scene, engine, threads), r in rows.items():
        if engine == "feder" or threads != "1":
            continue
        numbers = (ratio(rows, scene, engine, *what) for what in
                   (("1", "processor_ms"), ("2", "wall_ms"), ("1", "memory_mb")))
        lines.append(f"| {scene} ({r['steps']} steps) | {ENGINES[engine]} | {' | '.join(numbers)} | "
                     f"{end_states(rows, scene, engine)} |")
    versions = {}
    for r in rows.values():
        versions.setdefault((r["engine"], r["flags"]), {})[r["version"]] = None
    used = {engine: f"{' and '.join(found)} ({flags})" for (engine, flags), found in versions.items()}
    about = "; ".join(f"{name} {used[engine]}" for engine, name in ENGINES.items() if engine in used)
    lines += ["", textwrap.fill(f"feder {used.get('feder')}; {about}.", 120)]
    lines += ["", "| scene | beside | time over its | of |", "|---|---|---|---|"]
    for r in rows_of("rivals_by_hand.csv"):
        engine = f"{r['engine']} {r['commit']}, {r['flags']}"
        lines.append(f"| {r['scene']} | {engine} | {float(r['ratio']):.2f} | {r['end_state']} |")
    return "\n".join(lines)


def hello(feder, _):
    """What the scene of README.md prints; its check must hold, and it stays short."""
    scene = re.search(r"```lua\n(.*?)```", (ROOT / "README.md").read_text(), re.S)[1]
    if scene.count("\n") > 12:
        sys.exit(f"figures: hello has {scene.count(chr(10))} lines, more than 12")
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder, "hello.lua")
        file.write_text(scene)
        run(feder, "test", str(file))
        return "```\n" + run(feder, "run", "--quiet", str(file)).expandtabs(8).strip() + "\n```"


@functools.cache
def plan_nodes(feder):
    """(depth, name, system) of every pass and loop; a loop has no system, and its iterations per run in its name."""
    nodes, runs = [], {}
    for n in json.loads(run(feder, "explain", EVERYTHING, "--json", "--steps", "1"))["plan"]:
        if n["kind"] == "loop":
            runs[f"{n['path']}/{n['name']}"] = n["count"]
            nodes.append((n["path"].count("/"), f"{n['name']} x {n['count'] // runs.get(n['path'], 1)}", None))
        else:
            nodes.append((n["path"].count("/"), n["name"], n["system"]))
    return nodes


def tree(feder, _):
    """Loops and passes; names that repeat side by side stand once."""
    lines, passes, depth = ["```", "step"], [], 0

    def flush():
        names = [n.replace(" ", "_") for i, n in enumerate(passes) if i == 0 or n != passes[i - 1]]
        indent = "  " * (depth + 1)
        wrapped = textwrap.wrap(", ".join(names), 110, initial_indent=indent, subsequent_indent=indent,
                                break_on_hyphens=False)
        lines.extend(line.replace("_", " ") for line in wrapped)  # a name is not torn
        passes.clear()

    for at, name, system in plan_nodes(feder):
        if system is None or at != depth:
            flush()
            depth = at
        if system is None:
            lines.append("  " * (at + 1) + name)
            depth = at + 1
        else:
            passes.append(name)
    flush()
    return "\n".join([*lines, "```"])


def plan(feder, _):
    """The same, one pass a line, with its system."""
    rows = [("  " * (at + 1) + name, system or "") for at, name, system in plan_nodes(feder)]
    width = max(len(name) for name, _ in rows) + 2
    return "\n".join(["```", "step", *[f"{name:{width}}{system}".rstrip() for name, system in rows], "```"])


def variants(_feder, _folder):
    """What each module's CMakeLists.txt lists, and the tests that every one of them runs through."""
    rows = ["| family | variants | contract |", "|---|---|---|"]
    for path in sorted((ROOT / "runtime").glob("*/CMakeLists.txt")):
        family, text = path.parent.name, path.read_text()
        lines = re.findall(rf"^feder_(?:variant\({family} |kernel\()(\w+)(?: TABLE (\w+))?", text, re.M)
        names = [name for name, table in lines if not table]
        names += [f"{a}_{b}" for a, b in re.findall(r"^feder_pair\((\w+) (\w+)\)", text, re.M)]
        tests = sorted(t.name for t in (ROOT / "tests" / family).glob("test_*contract.cpp"))
        if names:
            tests = ", ".join(f"`tests/{family}/{t}`" for t in tests) or f"`tests/{family}`"
            rows.append(f"| `{family}` | {', '.join(f'`{n}`' for n in names)} | {tests} |")
        for table in dict.fromkeys(t for _, t in lines if t):
            own = ", ".join(f"`{n}`" for n, t in lines if t == table)
            rows.append(f"| `{family}`, {table} | {own} | `tests/{family}` |")
    return "\n".join(rows)


def scenes(_feder, folder):
    """By folder: title, first comment and parameters of every scene, and the command that draws them."""
    out = []
    for group in sorted(p for p in (ROOT / "scenes").iterdir() if p.is_dir()):
        out += ["", f"### {group.name}", ""]
        rows = ["| scene | title | what it shows | `--set` |", "|---|---|---|---|"]
        for path in sorted(p for p in group.rglob("*") if p.suffix in (".lua", ".yaml")):
            text = path.read_text()
            title = re.search(r'^ *title *[=:] *"?(.*?)"?,?$', text, re.M)
            comment = re.match(r"(?:(?:--|#) .*\n)+", text)[0]
            words = " ".join(line.lstrip("-# ") for line in comment.splitlines())
            names = re.findall(r'feder\.param\("(\w+)"', text) + re.findall(r"^  (\w+): \{ value:", text, re.M)
            cells = [f"[{path.name}]({os.path.relpath(path, folder)})", title[1] if title else "tests", words,
                     ", ".join(f"`{n}`" for n in names)]
            rows.append(f"| {' | '.join(cells)} |".replace("|  |", "| |"))
        if not any("| tests |" in row for row in rows):
            out += [f"`scripts/gallery build/{group.name}.png scenes/{group.name}` draws them.", ""]
        out += rows
    return "\n".join(out[1:])


def api(_feder, _folder):
    """Every function that a script sees, with what it says: tables of bindings/lua and rows of shapes."""
    text = r'((?:"(?:[^"\\]|\\.)*"\s*)+)'
    row = re.compile(rf'\{{\s*"\w+",\s*(?:guard|method)<.*?>,\s*{text},\s*{text}[,}}]', re.S)
    owners = {}

    def joined(literals):
        return "".join(re.findall(r'"((?:[^"\\]|\\.)*)"', literals)).replace('\\"', '"')

    for path in sorted((ROOT / "bindings/lua").glob("*.cpp")):
        found = row.findall(path.read_text())
        if len(found) != len(re.findall(r'\{\s*"\w+",\s*(?:guard|method)<[^;]*?>,\s*"', path.read_text())):
            sys.exit(f"figures: api: a row of {path} is not read")
        for signature, doc in found:
            owner = re.search(r"(\w+)[.:]\w", joined(signature))[1]
            says = re.sub(r";? ?see section \d( of the API)?", "", joined(doc)) or "options above"
            owners.setdefault(OWNERS.get(owner, owner), []).append(f"- `{joined(signature)}`: {says}")
    lists = (ROOT / "runtime/geom/CMakeLists.txt").read_text()
    for kind in re.findall(r"^feder_variant\(geom (\w+)(?: ALSO [^)]*)?\)", lists, re.M):
        source = (ROOT / f"runtime/geom/{kind}.cpp").read_text()
        usage, says = re.search(rf'return \{{\s*"{kind}",\s*"([^"]*)",\s*((?:"[^"]*"\s*)+),', source).groups()
        owners["feder"].append(f"- `feder.{kind}{usage} -> shape`: {joined(says)}")
    order = ("feder", "world", "object", "body", "joint", "region", "net", "cloth", "fluid", "emitter", "drain")
    names = [*order, *sorted(set(owners) - set(order))]
    return "\n\n".join("\n".join([f"**{name}**", "", *owners[name]]) for name in names)


def tolerances(_feder, _folder):
    """tests/rigid/tolerances.h as a table."""
    text = (ROOT / "tests/rigid/tolerances.h").read_text()
    fields = re.findall(r"^  double (\w+);\s*// (.*)$", text, re.M)
    solvers = re.findall(r'^      \{"(\w*)", (.*)\},$', text, re.M)
    rows = ["| what | " + " | ".join(f"`{name}`" if name else "others" for name, _ in solvers) + " |",
            "|---" * (1 + len(solvers)) + "|"]
    for i, (name, what) in enumerate(fields):
        rows.append(f"| `{name}`: {what} | " + " | ".join(numbers.split(", ")[i] for _, numbers in solvers) + " |")
    return "\n".join(rows)


# name: function(feder, folder of the document)
BLOCKS = {
    "hello": hello, "tree": tree, "rivals": rivals, "sheets": sheets,
    "plot": lambda f, d: stiff_chain(f, d).split("\n")[0], "plan": plan, "variants": variants, "scenes": scenes, "stiff_chain": stiff_chain, "orbit": orbit, "api": api,
    "rivals_all": rivals_all, "tolerances": tolerances, "fluids": fluids, "cloths": cloths,
    "hierarchies": hierarchies, "narrow_phases": narrow_phases, "broad_phases": broad_phases,
}
renewing = False


def find_blocks():
    """name -> documents it stands in."""
    places = {}
    for document in DOCUMENTS:
        for name in re.findall(r"<!-- figures: (\w+) -->", (ROOT / document).read_text()):
            places.setdefault(name, []).append(document)
    return places


def main(arguments):
    global renewing
    places = find_blocks()
    if arguments == ["--list"]:
        print("\n".join(f"{name}: {', '.join(places.get(name, ['nowhere']))}" for name in BLOCKS))
        return 0
    words = [a for a in arguments if a != "--renew"]
    names = words[1:] or list(BLOCKS)
    if not words or any(n not in BLOCKS for n in names):
        print(__doc__ + "\nBlocks: " + ", ".join(BLOCKS), file=sys.stderr)
        return 2
    renewing = "--renew" in arguments
    feder, bad = str(pathlib.Path(words[0]).resolve()), 0
    for name in sorted({*BLOCKS, *places}):
        found = places.get(name, [])
        if len(found) == 1 and name in BLOCKS:
            continue
        bad += 1
        where = f"stands in {' and '.join(found) or 'no document'}"
        print(f"figures: {name}: {where if name in BLOCKS else 'no command prints it'}")
    for name in names:
        if len(places.get(name, [])) != 1:
            continue
        path = ROOT / places[name][0]
        text = path.read_text()
        found = re.search(rf"(<!-- figures: {name} -->\n\n)((?:(?!<!-- ).)*?)\n*<!-- end -->", text, re.S)
        if not found:
            bad += 1
            print(f"figures: {name}: its block in {places[name][0]} has no end")
            continue
        now = BLOCKS[name](feder, path.parent)
        if now == found[2]:
            print(f"figures: {name}: as printed")
        elif renewing:
            path.write_text(f"{text[:found.end(1)]}{now}\n\n{text[found.end() - len('<!-- end -->'):]}")
            print(f"figures: {name}: renewed")
        else:
            bad += 1
            print(f"figures: {name}: {places[name][0]} says\n{found[2]}\nits commands print\n{now}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
