"""What feder aims at beside other engines, and the tables of scripts/compare: figures, and ratios beside the aims.

Rows come by (scene, engine, threads); times are those of compare.py.
"""

# Ratios to another engine: (scene, rival, threads, column) -> at most.
STACKS = ("many_pyramids", "square_pyramid", "wall", "columns")
OTHERS = ("washer", "convex_fall", "convex_pile", "joint_grid", "convex_vs_mesh")
BOUNDS = {
    ("large_pyramid", "box3d", 1, "processor_ms"): .62,
    **{(scene, "box3d", 1, "processor_ms"): .60 for scene in STACKS},
    **{(scene, "box3d", 1, "processor_ms"): .85 for scene in OTHERS},
    ("heavy_chains", "box3d", 1, "processor_ms"): 1.6,
    **{(scene, "jolt", 1, "processor_ms"): 1. for scene in ("large_pyramid", *STACKS, *OTHERS)},
    **{(scene, "box3d", 1, "memory_mb"): 1. for scene in ("large_pyramid", *STACKS, *OTHERS, "heavy_chains")},
}
# how much faster two threads are, and how their time compares with the better rival's
SPEEDUPS = {"large_pyramid": 1.7, "many_pyramids": 1.7, "joint_grid": 1.6, "washer": 1.5}
BETTER_RIVAL = .9
# time per body in a large scene over that in a small one
GROWTH = (("pyramid_50", "pyramid_200", 1.6),)
# end state of feder: a column, at most
STATES = {"heavy_chains": ("joint_error_m", 1e-3), "washer": ("overlap_m", .2), "large_pyramid": ("speed_m_s", .05)}


def verdict(found, most):
    return f"{found:.2f}" + ("" if most is None else f" ({'<=' if found <= most else 'ABOVE'} {most:.2f})")


def table(head, lines):
    widths = [max(len(str(line[k])) for line in [head, *lines]) for k in range(len(head))]
    for line in [head, *lines]:
        print("  ".join(str(word).ljust(width) for word, width in zip(line, widths)).rstrip())
    print()


def print_states(rows):
    lines = [(s, e, t, r["steps"], f"{r['processor_ms']:.3f}", f"{r['wall_ms']:.3f}", f"{r['memory_mb']:.1f}",
              f"{1e3 * r['sink_m']:.1f}", f"{1e3 * r['overlap_m']:.1f}", f"{r['speed_m_s']:.3f}",
              f"{1e3 * r['joint_error_m']:.2f}", f"{r['drift_m']:.3f}", r["asleep"], r["moved"],
              r["lost"] if r["finite"] else "NaN") for (s, e, t), r in rows.items()]
    table(("scene", "engine", "threads", "steps", "processor ms", "wall ms", "MB", "sink mm", "overlap mm", "speed m/s",
           "joint mm", "drift m", "asleep", "moved", "lost"), lines)


def print_ratios(rows):
    """feder over each rival, beside what feder aims at."""
    lines = []
    for (scene, engine, threads), rival in rows.items():
        ours = rows.get((scene, "feder", threads))
        if engine == "feder" or not ours:
            continue
        column = "processor_ms" if threads == 1 else "wall_ms"
        lines.append((scene, engine, threads,
                      verdict(ours[column] / rival[column], BOUNDS.get((scene, engine, threads, column))),
                      verdict(ours["memory_mb"] / max(rival["memory_mb"], 1e-9),
                              BOUNDS.get((scene, engine, threads, "memory_mb")))))
    if lines:
        table(("feder over", "engine", "threads", "time", "memory"), lines)


def print_threads(rows):
    lines = []
    for (scene, engine, threads), row in rows.items():
        one = rows.get((scene, engine, 1))
        if threads == 1 or not one:
            continue
        aim, better = "", ""
        speedup = one["wall_ms"] / row["wall_ms"]
        if engine == "feder" and scene in SPEEDUPS and threads == 2:
            aim = f" ({'>=' if speedup >= SPEEDUPS[scene] else 'BELOW'} {SPEEDUPS[scene]:.1f})"
            rivals = [r["wall_ms"] for (s, e, t), r in rows.items() if s == scene and t == threads and e != "feder"]
            better = verdict(row["wall_ms"] / min(rivals), BETTER_RIVAL) if rivals else ""
        lines.append((scene, engine, threads, f"{speedup:.2f}{aim}", better))
    if lines:
        table(("faster than one", "engine", "threads", "times", "over the better rival"), lines)


def print_growth(rows):
    lines = []
    for small, large, most in GROWTH:
        for (scene, engine, threads), row in rows.items():
            other = rows.get((small, engine, threads))
            if scene == large and threads == 1 and other:
                growth = row["processor_ms"] / row["bodies"] / (other["processor_ms"] / other["bodies"])
                lines.append((f"{large} over {small}", engine, verdict(growth, most if engine == "feder" else None)))
    if lines:
        table(("time per body", "engine", "times"), lines)


def print_aims(rows):
    lines = [(scene, column, f"{rows[scene, 'feder', 1][column]:.3g}", f"{most:g}",
              "ok" if rows[scene, "feder", 1][column] <= most else "ABOVE")
             for scene, (column, most) in STATES.items() if (scene, "feder", 1) in rows]
    if lines:
        table(("end state of feder", "figure", "found", "at most", ""), lines)


def print_all(rows):
    for part in (print_states, print_ratios, print_threads, print_growth, print_aims):
        part(rows)
