# SPDX-License-Identifier: MPL-2.0
"""What bench_quality's figures must reach, and lines that say whether they do."""

import numpy as np

from native.benchmarks.peers import methods

MEAN_RATIO, MEAN_AIM, WORST_RATIO = 0.836, 0.80, 1.05  # rms over CGAL's, 40 anchors
UNEVEN_DEG, VOLUME, ASYMMETRY, SPIKE = 10.0, 0.85, 0.01, 1.5
BUMP = 0.2  # change of the bumps' height over their height; ours to set: "keep their shape" has no figure


def lines(rows, mean_rows, cases):
    """Summary lines of all methods, then the goals of ours. Arguments: bench_quality's poses, means, cases."""
    found = [overall_line(mean_rows, *key) for key in summary_keys(mean_rows)]
    ours = [name for name in methods.OURS if any(row["method"] == name for row in [*mean_rows, *cases])]
    for name in ours:
        found += ["", *pose_goals(rows, mean_rows, name)]
        for row in cases:
            if row["method"] == name:
                found += case_goals(row)
    return found


def summary_keys(mean_rows):
    """(anchors, method) pairs that have ratios."""
    return dict.fromkeys((row["anchors"], row["method"]) for row in mean_rows if row.get("ratio") is not None)


def overall(mean_rows, anchors, method):
    """(mean over the sets of the mean ratio within each, worst pose's ratio, number of sets), or None."""
    members = [
        row for row in mean_rows
        if (row["anchors"], row["method"]) == (anchors, method) and row.get("ratio") is not None
    ]  # fmt: skip
    if not members:
        return None
    return float(np.mean([row["ratio"] for row in members])), max(row["worst ratio"] for row in members), len(members)


def overall_line(mean_rows, anchors, method):
    mean, worst, sets = overall(mean_rows, anchors, method)
    return f"{anchors} anchors, {method}: ratio {mean:.3f} over {sets} sets, worst pose {worst:.3f}"


def pose_goals(rows, mean_rows, method):
    """Goals on the ratio at 40 anchors, and the pose that misses by most."""
    result = overall(mean_rows, 40, method)
    if result is None:
        return [goal(False, f"{method}: no ratios: it or CGAL is missing")]
    mean, worst, _ = result
    aim = "aim reached" if mean <= MEAN_AIM else f"aim {MEAN_AIM:g}"
    bad = max((row for row in rows if row["method"] == method and row["anchors"] == 40 and "ratio" in row),
              key=lambda row: row["ratio"])  # fmt: skip
    where = f"{bad['set']} {bad['pose']}"
    return [
        goal(mean <= MEAN_RATIO, f"{method}: rms {mean:.3f} of CGAL's, goal {MEAN_RATIO:g} ({aim})"),
        goal(worst <= WORST_RATIO, f"{method}: worst pose {worst:.3f} of CGAL's ({where}), limit {WORST_RATIO:g}"),
    ]


def case_goals(row):
    """Goals on one of the handles' cases or checks."""
    head = f"{row['method']}: {row['case']}"
    if "missing" in row:
        return [goal(False, f"{head}: {row['missing']}")]
    found = []
    if row["case"] == "bar":
        found.append(goal(row["uneven deg"] <= UNEVEN_DEG, f"{head}: twist uneven by {row['uneven deg']:.3g} degrees"))
        found.append(goal(row["flipped"] == 0, f"{head}: {row['flipped']} flipped triangles"))
        found.append(goal(row["volume ratio"] > VOLUME, f"{head}: volume {row['volume ratio']:.3f} of what it was"))
    if row["case"] == "plane":
        text = f"{head}: bumps changed by {row['bump error']:.3g} of their height, lean by {row['bump tilt']:.3g}"
        found.append(goal(max(row["bump error"], row["bump tilt"]) <= BUMP, text))
    if row["case"] == "symmetric bend":
        text = f"{head}: off its mirror image by {row['asymmetry']:.2g} of the diagonal"
        found.append(goal(row["asymmetry"] <= ASYMMETRY, text))
    if row["case"] == "pulled anchor":
        text = f"{head}: height over its ring {row['spike']:.3g} times what it was"
        found.append(goal(row["spike"] <= SPIKE, text))
    return found


def goal(reached, text):
    return f"{'reached' if reached else 'MISSED '}  {text}"
