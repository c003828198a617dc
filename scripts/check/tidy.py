#!/usr/bin/env python3
"""clang-tidy with the checks of .clang-tidy: tidy.py [--changed [COMMIT]] [PATH...].

All sources under the paths (default: runtime), or with --changed those of them that differ from COMMIT
(default: HEAD). Flags come from build/release/compile_commands.json, so that preset must be configured. A check reads
all of Eigen and the standard library each time, and these are nearly all of what it reads: sources of one folder with
the same flags are read as one, where their names allow it, and singly where not. Exit status 1 when anything was found,
77 when there is no clang-tidy of the version that .clang-tidy was written for."""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "release"
VERSION = "14"
PROGRAMS = ("clang-tidy-" + VERSION, "clang-tidy")
FINDING = re.compile(r"^(/\S+?):(\d+):(\d+): (?:warning|error): (.*)$", re.M)


def find_tidy():
    for program in PROGRAMS:
        path = shutil.which(program)
        if not path:
            continue
        found = re.search(r"version (\d+)", subprocess.run([path, "--version"], capture_output=True, text=True).stdout)
        if found and found.group(1) == VERSION:
            return path
    return None


def flags(command):
    """What changes how a source reads: paths, definitions, the language. Asserts are on, so that they are read too."""
    words, kept = shlex.split(command), []
    for i, word in enumerate(words):
        if word == "-isystem":
            kept += words[i:i + 2]
        elif word.startswith(("-I", "-D", "-std=", "-mavx")) and word != "-DNDEBUG":
            kept.append(word)
    return tuple(kept)


def lumps(paths, changed):
    """Flags and the sources to read together, by folder."""
    found = {}
    for entry in json.loads((BUILD / "compile_commands.json").read_text()):
        source = pathlib.Path(entry["file"])
        if not source.is_relative_to(ROOT) or source.is_relative_to(BUILD):
            continue
        name = source.relative_to(ROOT).as_posix()
        if any(name == p or name.startswith(p + "/") for p in paths) and (changed is None or name in changed):
            found.setdefault((source.parent, flags(entry["command"])), set()).add(str(source))
    return [(key[1], sorted(sources)) for key, sources in sorted(found.items())]


def run(tidy, words, sources, folder):
    source = sources[0]
    if len(sources) > 1:
        handle, source = tempfile.mkstemp(suffix=".cpp", dir=folder)
        with os.fdopen(handle, "w") as lump:
            lump.writelines(f'#include "{s}"\n' for s in sources)
    out = subprocess.run([tidy, "--quiet", f"--config-file={ROOT}/.clang-tidy", f"--header-filter=^{ROOT}/", source, "--",
                          "-Wno-psabi", *words], capture_output=True, text=True).stdout
    if "[clang-diagnostic-error]" in out and len(sources) > 1:  # two that do not go together
        half = len(sources) // 2
        return run(tidy, words, sources[:half], folder) | run(tidy, words, sources[half:], folder)
    return {(file, int(line), int(column), text) for file, line, column, text in FINDING.findall(out)}


def changed_since(commit):
    out = subprocess.run(["git", "diff", "--name-only", commit], cwd=ROOT, capture_output=True, text=True, check=True)
    return set(out.stdout.split())


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n")[0])
    parser.add_argument("--changed", nargs="?", const="HEAD")
    parser.add_argument("paths", nargs="*")
    options = parser.parse_args()
    tidy = find_tidy()
    if not tidy:
        print(f"tidy: no clang-tidy {VERSION} here")
        return 77
    if not (BUILD / "compile_commands.json").is_file():
        print("tidy: build/release is not configured; scripts/build release does it")
        return 2
    paths = [p.rstrip("/") for p in options.paths] or ["runtime"]
    work = lumps(paths, changed_since(options.changed) if options.changed else None)
    found = set()
    with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for part in pool.map(lambda lump: run(tidy, *lump, folder), work):
            for file, line, column, text in sorted(part - found):
                print(f"{os.path.relpath(file, ROOT)}:{line}:{column}: {text}", flush=True)
            found |= part
    print(f"tidy: {sum(len(sources) for _, sources in work)} sources, {len(found)} findings")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
