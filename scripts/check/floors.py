#!/usr/bin/env python3
"""The floor check: a file includes its own module and lower floors only; modules of one floor are strangers.

Also: what the runtime may include at all, what its public headers may, which entries the top level may have, and how
long a file may be.
Each finding is one line `file:line: rule`. Exit status 1 when there is any.

  floors.py [ROOT]     check a tree (default: this checkout)
  floors.py --self-test   plant one violation of each rule in a copy and see it found
"""
import pathlib
import re
import subprocess
import sys
import tempfile

FLOORS = {
    "base": 0, "bounds": 1, "geom": 2, "linear": 2, "state": 3, "step": 4,
    "integrate": 5, "forces": 5, "broad": 5, "narrow": 5, "constrain": 5, "sph": 5, "neighbors": 5,
    "collide": 6, "springs": 6, "rigid": 6, "fluid": 6, "cloth": 6, "rope": 6, "soft": 6,
    "contact": 7, "couple": 8, "world": 9, "record": 10, "study": 10,
    "lua": 11, "yaml": 11, "meshes": 11, "report": 11, "view": 11, "cli": 11, "c": 11, "web": 11,
}
# Bindings of one floor that may know each other; everything else on one floor stays strangers.
NEIGHBORS = {
    "yaml": {"lua"},
    "meshes": {"lua"},
    "view": {"lua", "yaml", "report"},
    "cli": {"lua", "yaml", "meshes", "report", "view"},
    "web": {"lua", "view"},
}
# Public headers, runtime/include/feder/<name>.h, and whose they are: on that floor they may be included, but also by
# strangers where what they declare has its definitions in a lower room.
PUBLIC = {
    "types": "base", "error": "base", "params": "base", "memory": "base", "snapshot": "base", "profile": "base",
    "shape": "geom", "sdf": "geom", "object": "state", "events": "state", "body": "state", "plan": "step",
    "system": "step", "force": "forces", "integrator": "integrate", "joint": "constrain", "query": "collide",
    "net": "springs", "rigid": "rigid", "cloth": "cloth", "rope": "rope", "soft": "soft", "fluid": "fluid", "desc": "world", "world": "world",
    "systems": "world", "record": "record", "study": "study", "stability": "study", "lua": "lua", "parts": "lua", "yaml": "lua",
    "meshes": "lua",
}
PUBLIC_FOLDER = "runtime/include/feder"
EIGEN = {f"{PUBLIC_FOLDER}/types.h": {"Eigen/Core"}}
EIGEN_LINEAR = {"Eigen/Core", "Eigen/Sparse", "Eigen/SVD", "Eigen/Eigenvalues", "Eigen/Cholesky"}
INTRINSICS = {"immintrin.h", "xmmintrin.h", "emmintrin.h"}  # floating-point control words and base/simd.h
SYSTEM = {"base/semaphore.h": {"semaphore.h"}, "base/arena.cpp": {"sys/mman.h"}}  # POSIX; elsewhere the standard ones
# The runtime draws nothing, prints nothing and opens no files.
BANNED_STANDARD = {"iostream", "fstream", "ostream", "istream", "filesystem", "regex", "iomanip", "print"}
STANDARD = set("""
algorithm any array atomic barrier bit bitset cassert cctype cerrno cfenv cfloat charconv chrono cinttypes climits
cmath compare complex concepts condition_variable coroutine csignal cstdarg cstddef cstdint cstdio cstdlib cstring
ctime deque exception execution forward_list functional future initializer_list iterator latch limits list locale map
memory memory_resource mutex new numbers numeric optional queue random ranges ratio scoped_allocator semaphore set
shared_mutex source_location span sstream stack stdexcept stop_token streambuf string string_view syncstream
system_error thread tuple type_traits typeindex typeinfo unordered_map unordered_set utility valarray variant vector
version """.split())
TOP_LEVEL = {
    "CMakeLists.txt", "CMakePresets.json", "README.md", "LICENSE",
    "runtime", "bindings", "scripts", "scenes", "tests",
}
MAX_LINES = 600
CODE = {".h", ".cpp", ".inc", ".lua", ".py", ".cmake"}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def listed_files(root, *kinds):
    """Files of the checkout that git knows (and, with --others, would add); all files when the tree is no checkout."""
    out = subprocess.run(["git", "-C", str(root), "ls-files", "--cached", *kinds], capture_output=True, text=True,
                         check=False)
    if out.returncode == 0 and out.stdout:
        return sorted(p for p in map(pathlib.PurePosixPath, out.stdout.splitlines()) if (root / p).is_file())
    return sorted(pathlib.PurePosixPath(p.relative_to(root).as_posix()) for p in root.rglob("*") if p.is_file())


def floor_rule(module, target):
    """Why `module` may not include `target`, or None."""
    if target == module or FLOORS[target] < FLOORS[module]:
        return None
    if FLOORS[target] > FLOORS[module]:
        return f"floor {FLOORS[module]} ({module}) includes floor {FLOORS[target]} ({target}): includes go down only"
    if target in NEIGHBORS.get(module, ()):
        return None
    return f"{module} includes {target}: modules of floor {FLOORS[module]} are strangers"


def runtime_rule(path, module, bracket, name):
    """Why a runtime file may not include something that is no module of ours, or None."""
    if name.startswith("Eigen/") or name.startswith("unsupported/"):
        allowed = EIGEN_LINEAR if module == "linear" else EIGEN.get(path.as_posix(), set())
        return None if name in allowed else f"<{name}>: Eigen comes through feder/types.h (linear/ may use its solvers)"
    if name in BANNED_STANDARD:
        return f"<{name}>: the runtime draws, prints and reads nothing"
    if bracket == "<" and (name in STANDARD or name in INTRINSICS):
        return None
    if name in SYSTEM.get("/".join(path.parts[1:]), set()):
        return None
    if bracket == '"' and "/" not in name and name.endswith(".inc") and name.startswith(module):
        return None  # generated table of the module
    return f"{name}: the runtime uses Eigen/Core and the standard library only"


def check_file(root, path):
    text = (root / path).read_text(errors="replace").splitlines()
    if path.suffix in CODE and len(text) > MAX_LINES:
        yield f"{path}:{MAX_LINES + 1}: {len(text)} lines; files above {MAX_LINES} are split"
    if path.parts[0] not in ("runtime", "bindings") or path.suffix not in (".h", ".cpp", ".inc"):
        return
    public = path.parent.as_posix() == PUBLIC_FOLDER
    module = PUBLIC.get(path.stem, "") if public else path.parts[1] if len(path.parts) > 2 else ""
    if module not in FLOORS:
        yield f"{path}:1: '{module}' has no floor; add it to the table in scripts/check/floors.py"
        return
    for number, line in enumerate(text, 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        bracket, name = match.groups()
        head = name.split("/")[0]
        if bracket == '"' and head == "feder":
            owner = PUBLIC.get(name.split("/")[-1].removesuffix(".h"))
            rule = floor_rule(module, owner) if owner else f'"{name}" is no public header of the table in this script'
        elif public and not (
                bracket == "<" and (name in STANDARD or name in EIGEN.get(path.as_posix(), ()) or
                                    module == "lua" and name == "filesystem")):
            rule = f"{name}: a public header includes its like, the standard library and, in types.h, Eigen/Core"
        elif bracket == '"' and "/" in name and head in FLOORS:
            rule = floor_rule(module, head)
        elif path.parts[0] == "runtime" and not public:
            rule = runtime_rule(path, module, bracket, name)
        else:
            rule = f'"{name}": name the module in the path' if bracket == '"' and not name.endswith(".inc") else None
        if rule:
            yield f"{path}:{number}: {rule}"


def check_tree(root):
    findings = []
    for top in sorted({p.parts[0] for p in listed_files(root)}):
        if top not in TOP_LEVEL and not top.startswith("."):
            findings.append(f"{top}:1: not one of the top-level entries: {', '.join(sorted(TOP_LEVEL))}, dotfiles")
    for path in listed_files(root, "--others", "--exclude-standard"):
        if path.suffix in CODE:
            findings += check_file(root, path)
    return findings


PLANTED = {
    "runtime/springs/bad_up.cpp": ('#include "world/own.h"\n', "includes go down only"),
    "runtime/springs/bad_side.cpp": ('// a\n#include "rigid/impl.h"\n', "are strangers"),
    "runtime/springs/bad_public.cpp": ('#include "feder/rigid.h"\n', "are strangers"),
    "runtime/springs/bad_name.cpp": ('#include "feder/spring.h"\n', "no public header"),
    "runtime/include/feder/cloth.h": ('#include "cloth/batch.h"\n', "a public header includes its like"),
    "runtime/broad/bad_eigen.cpp": ("#include <Eigen/Dense>\n", "Eigen comes through"),
    "runtime/broad/bad_print.cpp": ("#include <iostream>\n", "draws, prints and reads nothing"),
    "runtime/broad/bad_lua.cpp": ("#include <lua.hpp>\n", "standard library only"),
    "runtime/world/bad_binding.cpp": ('#include "lua/state.h"\n', "includes go down only"),
    "runtime/helpers/bad_module.cpp": ("\n", "has no floor"),
    "bindings/lua/bad_side.cpp": ('#include "cli/session.h"\n', "are strangers"),
    "bindings/cli/bad_path.cpp": ('#include "session.h"\n', "name the module"),
    "tests/base/bad_long.cpp": ("\n" * (MAX_LINES + 1), "files above"),
    "notes/plan.md": ("notes\n", "not one of the top-level entries"),
}
CLEAN = {
    ".github/CONTRIBUTING.md": "dotfiles may stand at the top\n",
    "runtime/include/feder/types.h": "#include <Eigen/Core>\n#include <cstdint>\n",
    "runtime/world/own.h": '#include "base/jobs.h"\n#include "feder/world.h"\n',
    "runtime/broad/registry.cpp": '#include "broad_rows.inc"\n',
    "bindings/cli/run.cpp": '#include <CLI/CLI.hpp>\n#include "feder/lua.h"\n#include "report/table.h"\n',
}


def self_test():
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)

        def write(name, text):
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            (root / name).write_text(text)

        for name, text in CLEAN.items():
            write(name, text)
        for finding in check_tree(root):
            failures += 1
            print(f"self-test: found in a clean tree: {finding}")
        for name, (text, _) in PLANTED.items():
            write(name, text)
        findings = check_tree(root)
        for name, (_, rule) in PLANTED.items():
            where = name.split("/")[0] if name.startswith("notes") else name
            if not any(f.startswith(where + ":") and rule in f for f in findings):
                failures += 1
                print(f"self-test: not found: {name}: {rule}")
        if len(findings) != len(PLANTED):
            failures += 1
            print(f"self-test: {len(findings)} findings for {len(PLANTED)} planted violations:", *findings, sep="\n  ")
    print("self-test:", "failed" if failures else f"all {len(PLANTED)} planted violations found")
    return 1 if failures else 0


def main(arguments):
    if arguments == ["--self-test"]:
        return self_test()
    root = pathlib.Path(arguments[0]) if arguments else pathlib.Path(__file__).resolve().parents[2]
    findings = check_tree(root)
    for finding in findings:
        print(finding)
    print(f"floors: {len(findings)} findings" if findings else "floors: clean")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
