#!/usr/bin/env python3
"""The study suite `core` against its stored points: counts and verdicts exactly, errors to a thousandth.

  study_core.py FEDER REAL            compare with tests/golden/study_core_REAL.csv (REAL: float or double)
  study_core.py --renew FEDER REAL    store the points of this build instead; look at the diff before committing it

Rows of methods that are new are not compared, so a new integrator needs no renewal to pass; it needs one to be guarded.
Seconds and other columns that differ from run to run are not stored.
"""
import csv
import pathlib
import subprocess
import sys
import tempfile

KEPT = ("problem,method,order,h_s,tol,iters,substeps,status,status_t_s,steps,rejected,force_evals,jac_evals,"
        "linear_solves,cg_iters,err_end,err_traj_rms,err_energy_max").split(",")


def baseline(real):
    return pathlib.Path(__file__).resolve().parents[2] / "tests" / "golden" / f"study_core_{real}.csv"


def renew(feder, real):
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([feder, "study", "--suite", "core", "--repeat", "0", "--quiet", "--out", folder], check=True)
        with open(pathlib.Path(folder) / "points.csv", newline="") as file:
            rows = list(csv.DictReader(file))
    with open(baseline(real), "w", newline="") as file:
        writer = csv.DictWriter(file, KEPT, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"stored {len(rows)} points in {baseline(real)}")
    return 0


def main(arguments):
    again = "--renew" in arguments
    words = [a for a in arguments if a != "--renew"]
    if len(words) != 2 or words[1] not in ("float", "double"):
        print(__doc__, file=sys.stderr)
        return 2
    if again:
        return renew(*words)
    return subprocess.run([words[0], "study", "--suite", "core", "--repeat", "0", "--quiet",
                           "--baseline", str(baseline(words[1]))], check=False).returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
