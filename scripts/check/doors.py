#!/usr/bin/env python3
"""The door check: how many files outside its own name each thing of the house. The numbers may only fall.

A system, coupling, shape, joint or variant should enter by one door: its own files and the line that lists it. Every
other file of runtime/ and bindings/ that names it (an include of its header, its class or factory, its library, its
name as a word in quotes) has to be edited, or read, when such a thing is added. Comments do not count; studies, tests
and scenes use things, so they do not count either, nor do couplings count for the systems that they couple.

  doors.py             compare with tests/golden/doors.json; exit status 1 when a number has grown or nobody stored it
  doors.py --list T    the files that name thing T, e.g. `system cloth`
  doors.py --renew     store the numbers, which must not be above the stored ones unless --allow is given too
"""
import json
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
STORED = ROOT / "tests/golden/doors.json"
WANTED = {"system": 4, "coupling": 1, "shape": 1, "joint": 1, "variant": 1}
# Words by which a system's files in bindings/ and elsewhere are known to be its own.
BODIES = ("rigid", "body", "bodies", "joint", "region", "queries")  # what collide serves
OWN = {"springs": ("springs", "net"), "rigid": BODIES, "cloth": ("cloth",), "rope": ("rope",), "soft": ("soft",), "fluid": ("fluid", "emitter"),
       "collide": ("collide", *BODIES), "contact": ("contact", "surface")}
PUBLIC = {"springs": "net", "collide": "query"}  # feder/<name>.h of the system, where it is called otherwise
# Where a system's name in quotes is the name of something else: a layer, node, event, part of a suite, option.
ELSEWHERE = {"rope": {"bindings/lua/joint.cpp"}, "springs": {"bindings/view/toggles.cpp", "bindings/view/export_gltf.cpp"},
             "contact": {"runtime/include/feder/events.h", "bindings/cli/study_suite.cpp",
                         "bindings/lua/expect_world.cpp"}}
# A variant's name in quotes is its own only where its family is named too: "drag" is an option of cloth elsewhere.
FAMILY = {"forces": "force_kinds", "constrain": "joint_kinds", "broad": "broad_phases", "rigid": "rigid_solver",
          "cloth": "cloth_solver", "soft": "soft_solver", "soft.laws": "elastic_laws", "fluid": "fluid_solver",
          "integrate": r"integrators\b", "neighbors": "neighbor_searches", "bounds": "bounding_volumes",
          "bounds.builds": "tree_builds", "bounds.searches": "box_searches",
          "geom.indexes": "triangle_indexes", "narrow.methods": "narrow_methods"}
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
HASH_COMMENT = re.compile(r"#[^\n]*")
VARIANT = re.compile(r"^\s*feder_variant\((\w+) (\w+)(?: TABLE (\w+))?", re.M)
SYSTEM = re.compile(r"class (\w+) final : public System\b")
COUPLING = re.compile(r'class (\w+) final : public System \{.*?kName = "(\w+)"', re.S)


def sources():
    """Path and text without comments of every file that counts."""
    for top in ("runtime", "bindings"):
        for path in sorted((ROOT / top).rglob("*")):
            if path.parts[len(ROOT.parts):][:2] == ("runtime", "study"):
                continue
            if path.suffix in (".h", ".cpp", ".inc"):
                yield path.relative_to(ROOT).as_posix(), COMMENT.sub("", path.read_text(errors="replace"))
            elif path.name == "CMakeLists.txt":
                yield path.relative_to(ROOT).as_posix(), HASH_COMMENT.sub("", path.read_text())


def words(path):
    return set(re.split(r"[/._]", path))


def pascal(name):
    return "".join(part.capitalize() for part in name.split("_"))


def things():
    """(kind, name, pattern, is_own, family) of every thing; where family is found its name in quotes is meant."""
    for system, own in OWN.items():
        headers = [h.read_text() for h in [*(ROOT / f"runtime/{system}").glob("*.h"),
                                           ROOT / f"runtime/include/feder/{PUBLIC.get(system, system)}.h"] if h.exists()]
        classes = {c for text in headers for c in SYSTEM.findall(text)}
        pattern = "|".join([rf'"{system}/', rf'"feder/{PUBLIC.get(system, system)}\.h"', rf'"{system}"', rf"\bfeder_{system}\b", rf"FEDER_HAS_{system.upper()}\b"] +
                           [rf"\b{c}\b" for c in sorted(classes)])
        assert classes, system
        is_own = lambda p, o=own, s=system: (p.startswith(f"runtime/{s}/") or p == f"runtime/include/feder/{PUBLIC.get(s, s)}.h" or words(p) & set(o) or
                                             p in ELSEWHERE.get(s, ()) or
                                             p.startswith("runtime/couple/") and not p.endswith("CMakeLists.txt"))
        yield "system", system, pattern, is_own, None
    for header in sorted((ROOT / "runtime/couple").glob("*.h")):
        for cls, name in COUPLING.findall(header.read_text()):
            pattern = rf'couple/{header.name}"|"{name}"|\b{cls}\b'
            yield "coupling", name, pattern, lambda p, n=name: p.startswith(f"runtime/couple/{n}"), None
    for path in sorted((ROOT / "runtime").glob("*/CMakeLists.txt")):
        folder = path.parent.name
        if folder in ("study", "sph"):  # problems and kernels are made in loops over names
            continue
        variants = VARIANT.findall(path.read_text())
        shapes = {name for module, name, table in variants if module == "geom" and not table} | {"frustum"}
        for module, name, table in variants:
            kind = "variant" if table else {"geom": "shape", "constrain": "joint"}.get(module, "variant")
            pattern = rf'{module}/{name}\.h"|\b{module}_{name}\b'
            if kind == "shape":  # a test of a pair of shapes is a door of its own; a shape may be made of others
                pattern += rf'|"{name}"|\bmake_{name}\b|\b{pascal(name)}Shape\b'
                own = lambda p, n=name, all=shapes: (
                    p.startswith("runtime/geom/") and (words(p) & all or p.endswith("CMakeLists.txt")) or
                    p == f"runtime/bounds/{n}.cpp" or p.startswith("runtime/narrow/") and n in p or p.startswith("bindings/") and n in words(p))
                yield kind, f"{module}.{name}", pattern, own, None
                continue
            own = lambda p, f=f"runtime/{folder}/", n=name: p.startswith(f) and (n.rstrip("0123456789") in p or p.endswith("CMakeLists.txt"))
            yield kind, f"{module}.{name}", pattern, own, re.compile(FAMILY[f"{module}.{table}" if table else module])


def count():
    files = list(sources())
    found = {}
    for kind, name, pattern, own, family in things():
        rule, quoted = re.compile(pattern), f'"{name.split(".")[-1]}"'
        # a system's name alone is its word where things are listed
        listed = re.compile(rf"{pattern}|\b{name}\b" if kind == "system" else pattern)
        found[f"{kind} {name}"] = [path for path, text in files if not own(path) and
                                   ((listed if path.endswith("CMakeLists.txt") else rule).search(text) or
                                    family and quoted in text and family.search(text))]
    return found


def main(arguments):
    found = count()
    if arguments[:1] == ["--list"]:
        print("\n".join(found[" ".join(arguments[1:])]))
        return 0
    stored = json.loads(STORED.read_text()) if STORED.exists() else {}
    grown = [t for t, files in found.items() if len(files) > stored.get(t, -1)]
    if "--renew" in arguments:
        worse = [t for t in grown if t in stored]
        if worse and "--allow" not in arguments:
            print("\n".join(f"doors: {t}: {len(found[t])} files, stored {stored[t]}" for t in worse), file=sys.stderr)
            return 1
        STORED.write_text(json.dumps({t: len(f) for t, f in sorted(found.items())}, indent=1) + "\n")
        print(f"doors: stored {len(found)} numbers")
        return 0
    for t in grown:
        print(f"doors: {t}: named by {len(found[t])} files, stored {stored.get(t, 'nothing')}: {', '.join(found[t])}",
              file=sys.stderr)
    for kind, wanted in WANTED.items():
        numbers = {t.split()[1]: len(f) for t, f in found.items() if t.startswith(kind + " ")}
        worst = max(numbers, key=numbers.get)
        over = sum(n > wanted for n in numbers.values())
        print(f"doors: {kind}: at most {numbers[worst]} ({worst}), {over} of {len(numbers)} above {wanted}")
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
