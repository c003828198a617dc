#!/usr/bin/env python3
"""Adds up a test run for scripts/test: tally.py FOLDER SECONDS. Prints the slowest suites, what the whole took (SECONDS
ago it began), what failed, and then one closing line.

FOLDER holds the JUnit files of ctest (a Catch2 program counts with its test cases, any other test as one), the output
of `feder test` in scenes.txt, and lines "name passed|failed|skipped" of other steps in the file `steps`.
"""
import pathlib
import re
import sys
import xml.etree.ElementTree as xml

ALL_PASSED = re.compile(r"All tests passed \(\d+ assertions? in (\d+) test cases?\)")
SOME_FAILED = re.compile(r"^test cases:\s*(\d+) \|(.*)$", re.M)
CLOSING = re.compile(r"^(\d+) passed, (\d+) failed, (\d+) skipped$", re.M)

SLOWEST = 5


class Tally:
    def __init__(self):
        self.passed = self.failed = self.skipped = 0
        self.names = []

    def add(self, passed, failed, skipped, name):
        self.passed += passed
        self.failed += failed
        self.skipped += skipped
        if failed:
            self.names.append(f"{name} ({failed})" if failed > 1 else name)


def add_ctest_case(tally, preset, case):
    name = f"{preset}: {case.get('name')}"
    output = case.findtext("system-out") or ""
    status = case.get("status")
    if status == "run":
        match = ALL_PASSED.search(output)
        tally.add(int(match.group(1)) if match else 1, 0, 0, name)
    elif status in ("notrun", "disabled"):
        skipped = case.find("skipped") is not None and "missing" not in (case.find("skipped").get("message") or "").lower()
        tally.add(0, 0 if skipped else 1, 1 if skipped else 0, name)
    else:
        match = SOME_FAILED.search(output)
        total = int(match.group(1)) if match else 1
        counts = re.search(r"(\d+) failed", match.group(2)) if match else None
        failed = max(1, int(counts.group(1))) if counts else 1  # a crash fails at least itself
        tally.add(max(0, total - failed), failed, 0, name)


def print_slowest(reports, seconds):
    suites = [(float(case.get("time") or 0), f"{report.stem}: {case.get('name')}")
              for report in reports for case in xml.parse(report).getroot().iter("testcase")]
    slowest = sorted(suites, reverse=True)[:SLOWEST]
    print("slowest: " + ", ".join(f"{name} {time:.0f} s" for time, name in slowest))
    print(f"total: {seconds / 60:.1f} min, with building and installing")


def main(folder, seconds):
    tally = Tally()
    reports = sorted(folder.glob("*.xml"))
    for report in reports:
        for case in xml.parse(report).getroot().iter("testcase"):
            add_ctest_case(tally, report.stem, case)
    steps = folder / "steps"
    for line in steps.read_text().splitlines() if steps.exists() else ():
        name, result = line.rsplit(" ", 1)
        # a red ctest is already counted test by test
        counted = name.startswith("ctest.") and (folder / f"{name[6:]}.xml").exists() and tally.failed
        if not counted:
            tally.add(result == "passed", result not in ("passed", "skipped"), result == "skipped", name)
    scenes = folder / "scenes.txt"
    if scenes.exists():
        closing = CLOSING.findall(scenes.read_text(errors="replace"))
        if closing:
            tally.add(*map(int, closing[-1]), "scenes")
        else:
            tally.add(0, 1, 0, "scenes (feder test did not finish)")
    print_slowest(reports, seconds)
    if tally.names:
        print("failed: " + ", ".join(tally.names))
    print(f"{tally.passed} passed, {tally.failed} failed, {tally.skipped} skipped")
    return 0 if tally.failed == 0 and tally.passed > 0 else 1


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]), float(sys.argv[2])))
