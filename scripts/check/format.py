#!/usr/bin/env python3
"""C++ as clang-format writes it, by .clang-format: format.py [--mend].

Exit status 1 when a file differs (each is named with its first line), 77 when there is no clang-format of the version
that .clang-format was written for: others lay out some things differently. --mend rewrites the files instead."""
import pathlib
import re
import shutil
import subprocess
import sys

VERSION = "14"
PROGRAMS = ("clang-format-" + VERSION, "clang-format")


def find_formatter():
    for program in PROGRAMS:
        path = shutil.which(program)
        if not path:
            continue
        found = re.search(r"version (\d+)", subprocess.run([path, "--version"], capture_output=True, text=True).stdout)
        if found and found.group(1) == VERSION:
            return path
    return None


def main(mend):
    root = pathlib.Path(__file__).resolve().parents[2]
    formatter = find_formatter()
    if not formatter:
        print(f"format: no clang-format {VERSION} here")
        return 77
    listed = subprocess.run(["git", "ls-files", "*.cpp", "*.h"], cwd=root, capture_output=True, text=True)
    if listed.returncode:
        print("format: no checkout of git here")
        return 77
    files = [f for f in listed.stdout.splitlines() if (root / f).is_file()]
    if mend:
        return subprocess.run([formatter, "-i", *files], cwd=root).returncode
    out = subprocess.run([formatter, "--dry-run", *files], cwd=root, capture_output=True, text=True).stderr
    bad = {}
    for file, line in re.findall(r"^(.+?):(\d+):\d+: warning: code should be clang-formatted", out, re.M):
        bad.setdefault(file, line)
    for file, line in bad.items():
        print(f"{file}:{line}: not as clang-format writes it; scripts/check/format.py --mend rewrites it")
    print(f"format: {len(files)} files, {len(bad)} differ")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:] == ["--mend"]))
