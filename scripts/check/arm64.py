#!/usr/bin/env python3
"""The golden hashes (float, after 60 steps) from a program for 64-bit ARM, under qemu: arm64.py [SCENE-PATTERN].

Cross-builds the program without view and YAML in build/arm64. Its libraries are Debian's for arm64, unpacked beside the
build: the machine's own stay as they are. Exit status 77 where the cross compiler, qemu or the packages are missing
(scripts/setup --all installs them)."""
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys

import golden

ROOT = golden.ROOT
BUILD = ROOT / "build" / "arm64"
LIBRARIES = BUILD / "libraries"
STEPS = 60


def skip(why):
    print(f"arm64: skipped: {why} (scripts/setup --all)")
    sys.exit(77)


def unpack():
    if (LIBRARIES / "done").exists():
        return
    LIBRARIES.mkdir(parents=True, exist_ok=True)
    packages = [p + ":arm64" for p in ("liblua5.4-dev", "libfmt-dev", "libfmt9")]
    if subprocess.run(["apt-get", "download", "-q", *packages], cwd=LIBRARIES, capture_output=True, check=False).returncode:
        skip("no packages for arm64")
    for package in LIBRARIES.glob("*.deb"):
        subprocess.run(["dpkg", "-x", package, LIBRARIES], check=True)
    (LIBRARIES / "done").touch()


def build():
    if not (BUILD / "build.ninja").exists():
        subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        f"-DCMAKE_TOOLCHAIN_FILE={ROOT}/scripts/cmake/arm64.cmake", f"-DFEDER_ARM64_LIBRARIES={LIBRARIES}",
                        "-DFEDER_TESTS=OFF", "-DFEDER_WITHOUT=view;live;window;yaml"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["ninja", "-C", BUILD, "--quiet", "feder"], check=True)
    runner = BUILD / "run"
    runner.write_text(f"#!/bin/sh\nexec qemu-aarch64 -L /usr/aarch64-linux-gnu "
                      f"-E LD_LIBRARY_PATH={LIBRARIES}/usr/lib/aarch64-linux-gnu {BUILD}/feder \"$@\"\n")
    os.chmod(runner, 0o755)
    return str(runner)


def main(pattern=""):
    for tool in ("aarch64-linux-gnu-g++", "qemu-aarch64", "apt-get"):
        if not shutil.which(tool):
            skip(f"no {tool}")
    unpack()
    feder = build()
    stored = dict(line.rsplit(" ", 1) for line in golden.FILE.read_text().splitlines() if golden.mine(line, "float"))

    def one(case):
        scene, options, dt = case
        return " ".join(f"float {scene} {options} {STEPS}".split()), golden.run(feder, scene, options, STEPS * dt)[1]

    cases = [c for c in golden.cases() if not c[0].endswith(".yaml") and re.search(pattern, f"{c[0]} {c[1]}")]
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        hashes = dict(pool.map(one, cases))
    differ = [key for key, value in hashes.items() if stored.get(key) != value]
    for key in differ:
        print(f"arm64: {key}: stored {stored.get(key, 'nothing')}, is {hashes[key]}")
    print(f"arm64: {len(hashes)} hashes, {len(differ)} differ")
    return 1 if differ or not hashes else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
