# SPDX-License-Identifier: MPL-2.0
"""Quality beside the peers, each run to convergence, all from the rest shape.

Ground truth: every third pose of the two sequences and all others, thinned out. Anchors are the true pose's own
vertices at farthest points of the rest shape, 40 with every method, 17 with ours and CGAL's spokes and rims. Errors are
over the rest shape's bounding-box diagonal. Then the two set-ups under handles/ and two analytic checks.
"""

import argparse
import json
import pathlib
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import quality_cases, quality_goals, reporting, shape_metrics
from native.benchmarks.peers import methods

POSE_COLUMNS = [
    "set", "pose", "anchors", "method", "rms", "max", "ratio", "edge rms", "dihedral deg", "flipped",
    "intersecting", "volume ratio", "seconds",
]  # fmt: skip
FEW_ANCHOR_PEERS = (methods.CGAL,)
# libigl's spokes are left to --peers: its negative weights make folds (three in a hundred triangles flip).
DEFAULT_PEERS = [name for name in methods.PEERS if name != "libigl spokes"]
TRUTH = "(true pose)"
HANDLES = "handles"
DEFAULT_OURS = ("fast",)


def pose_rows(pose_set, method, with_triangles, time_limit):
    """A dictionary by POSE_COLUMNS for each pose; one with `missing` when the method gave nothing."""
    job = pose_set.job
    head = {"set": pose_set.name, "anchors": len(job.anchors), "method": method.name if method else TRUTH}
    if method is None:
        shapes, seconds = pose_set.truths, [0.0] * len(pose_set.truths)
    else:
        outcome = methods.run(method, job, method.quality_iterations, time_limit)
        if outcome.missing:
            return [{**head, "missing": outcome.missing}]
        shapes, seconds = outcome.shapes, outcome.result["seconds"]
    pairs = methods.self_intersections(job.vertices, job.faces, shapes) if with_triangles else [None] * len(shapes)
    rows = []
    for k, (shape, truth) in enumerate(zip(shapes, pose_set.truths, strict=True)):
        rms, largest = shape_metrics.vertex_errors(shape, truth, job.diagonal)
        rows.append({
            **head, "pose": int(pose_set.numbers[k]), "rms": rms, "max": largest,
            "edge rms": shape_metrics.edge_error(shape, truth, job.faces),
            "dihedral deg": shape_metrics.dihedral_error(shape, truth, job.faces),
            "flipped": shape_metrics.flipped_triangles(shape, job.vertices, job.faces), "intersecting": pairs[k],
            "volume ratio": shape_metrics.volume(shape, job.faces) / shape_metrics.volume(truth, job.faces),
            "seconds": seconds[k],
        })  # fmt: skip
    print(f"{pose_set.name}, {head['anchors']} anchors: {head['method']}: {len(rows)} poses done", flush=True)
    return rows


def add_ratios(rows):
    """The rms over that of CGAL's spokes and rims on the same pose, where both are there."""
    reference = {place(row): row["rms"] for row in rows if row["method"] == methods.CGAL and "missing" not in row}
    for row in rows:
        if "missing" not in row and row["method"] != TRUTH and place(row) in reference:
            row["ratio"] = row["rms"] / reference[place(row)]


def place(row):
    return row["set"], row["anchors"], row.get("pose")


def means(rows):
    """A row for each set, anchor count and method: means over the poses; `ratio` is the mean of the poses' ratios."""
    groups = {}
    for row in rows:
        groups.setdefault((row["set"], row["anchors"], row["method"]), []).append(row)
    found = []
    for (name, anchors, method), members in groups.items():
        mean = {"set": name, "anchors": anchors, "method": method}
        if "missing" in members[0]:
            found.append({**mean, "missing": members[0]["missing"]})
            continue
        for column in POSE_COLUMNS[4:]:
            values = [row[column] for row in members if row.get(column) is not None]
            mean[column] = float(np.mean(values)) if values else None
        mean["max"] = max(row["max"] for row in members)
        mean["worst ratio"] = max((row["ratio"] for row in members if "ratio" in row), default=None)
        found.append({**mean, "poses": len(members)})
    return found


def handle_rows(method, time_limit):
    """Dictionaries for the bar, the plane, the symmetric bend and the pulled anchor."""
    rows = []
    for name, job, measure in handle_cases():
        row = {"case": name, "method": method.name}
        outcome = methods.run(method, job, method.quality_iterations, time_limit)
        if outcome.missing:
            rows.append({**row, "missing": outcome.missing})
            continue
        shape = outcome.shapes[0]
        pairs = methods.self_intersections(job.vertices, job.faces, outcome.shapes)[0]
        rows.append({
            **row, **measure(shape), "flipped": shape_metrics.flipped_triangles(shape, job.vertices, job.faces),
            "intersecting": pairs, "seconds": outcome.result["seconds"][0],
            "anchor miss": float(np.abs(shape[job.anchors] - job.targets[0]).max() / job.diagonal),
        })  # fmt: skip
    print(f"{HANDLES}: {method.name}: done", flush=True)
    return rows


def handle_cases():
    """(name, job, what is measured of a shape beside the rest) of each case."""
    for name, function in (("bar", bar_measures), ("plane", plane_measures)):
        case = quality_cases.handles(name)
        if case:
            yield name, case[0], function(*case)
    bend = quality_cases.symmetric_bend()
    yield "symmetric bend", bend, lambda shape: {
        "asymmetry": shape_metrics.asymmetry(shape, bend.vertices, 2, bend.diagonal)
    }
    pulled, top = quality_cases.pulled_anchor()
    before = shape_metrics.ring_height(pulled.vertices, pulled.faces, top)
    yield "pulled anchor", pulled, lambda shape: {
        "spike": shape_metrics.ring_height(shape, pulled.faces, top) / before
    }


def bar_measures(job, kinds):
    """Twist by height, and volume."""
    axis = quality_cases.long_axis(job.vertices)
    sections = quality_cases.cross_sections(job.vertices, kinds, axis)
    ends = [np.flatnonzero(kinds == kind) for kind in (0, 2)]
    order = ends if job.vertices[ends[0], axis].mean() < job.vertices[ends[1], axis].mean() else ends[::-1]
    # The first layer of each fixed end: where the twist begins.
    first = order[0][job.vertices[order[0], axis] >= job.vertices[order[0], axis].max() - 1e-9]
    last = order[1][job.vertices[order[1], axis] <= job.vertices[order[1], axis].min() + 1e-9]
    sections = [first, *sections, last]

    def measured(shape):
        heights, turns = shape_metrics.section_turns(shape, job.vertices, axis, sections)
        return {
            "uneven deg": shape_metrics.twist_unevenness(heights, turns),
            "volume ratio": shape_metrics.volume(shape, job.faces) / shape_metrics.volume(job.vertices, job.faces),
            "heights": heights.tolist(), "turns": turns.tolist(),
        }  # fmt: skip

    return measured


def plane_measures(job, kinds):
    """Bumps, away from what is held: there the surface has a crease that is no bump."""
    held = kinds != 1
    for _ in range(5):
        pairs = shape_metrics.unique_edges(job.faces)
        grown = held.copy()
        grown[pairs[held[pairs[:, 0]], 1]] = grown[pairs[held[pairs[:, 1]], 0]] = True
        held = grown

    def measured(shape):
        height_error, tilt = shape_metrics.bump_errors(shape, job.vertices, job.faces, ~held)
        return {"bump error": height_error, "bump tilt": tilt}

    return measured


def parse():
    """The arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--ours", default=DEFAULT_OURS, type=lambda text: text.split(";"),
                        help=f"our methods, by semicolons: {'; '.join(methods.OURS)}")  # fmt: skip
    parser.add_argument("--only", choices=["ours", "peers"], help="without peers there are no ratios")
    parser.add_argument("--peers", default=DEFAULT_PEERS, type=lambda text: text.split(";"),
                        help=f"by semicolons: {'; '.join(methods.PEERS)}")  # fmt: skip
    parser.add_argument("--sets", default=[*quality_cases.POSE_SETS, HANDLES], type=lambda text: text.split(","),
                        help=f"of {', '.join(quality_cases.POSE_SETS)}, {HANDLES} (default: all)")  # fmt: skip
    parser.add_argument("--anchors", default=[40, 17], type=lambda text: [int(part) for part in text.split(",")])
    parser.add_argument("--thin-out", type=int, default=3, help="take only every so many poses (default: 3; 1: all)")
    parser.add_argument("--time-limit", type=float, default=240.0, help="seconds for all poses of a set")
    parser.add_argument("--jobs", type=int, default=2, help="runs at a time; seconds are not compared here")
    return parser.parse_args()


def chosen_methods(arguments, anchor_count):
    """None for the truth itself, then ours, then the peers."""
    chosen = [] if arguments.only == "peers" else [methods.OURS[name] for name in arguments.ours]
    if arguments.only != "ours":
        peers = [name for name in arguments.peers if anchor_count >= 40 or name in FEW_ANCHOR_PEERS]
        chosen += [methods.PEERS[name] for name in peers]
    return chosen


def measure(arguments):
    """(rows of the poses, rows of the handles)."""
    tasks = []
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for count in arguments.anchors:
            for pose_set in quality_cases.pose_sets(arguments.sets, count, arguments.thin_out):
                for method in [None, *chosen_methods(arguments, count)]:
                    tasks.append(pool.submit(pose_rows, pose_set, method, count >= 40, arguments.time_limit))
        others = [
            pool.submit(handle_rows, method, arguments.time_limit)
            for method in (chosen_methods(arguments, 40) if HANDLES in arguments.sets else [])
        ]
        rows = [row for task in tasks for row in task.result()]
        return rows, [row for task in others for row in task.result()]


def main(arguments):
    """Measures, prints, writes."""
    methods.build_cgal_quietly()  # once, before two runs want it
    rows, others = measure(arguments)
    add_ratios(rows)
    mean_rows = means(rows)
    reasons = [f"{row['method']}: {row['missing']}" for row in [*mean_rows, *others] if "missing" in row]
    for reason in dict.fromkeys(reasons):
        reporting.missing(reason)
    columns = ["set", "anchors", "method", "poses", *POSE_COLUMNS[4:7], "worst ratio", *POSE_COLUMNS[7:]]
    reporting.report("ground truth: means over poses; max is the largest; ratio is of rms to CGAL spokes and rims",
                     columns, [table_row(row, columns) for row in mean_rows], arguments.json)  # fmt: skip
    case_columns = ["case", "method", "uneven deg", "volume ratio", "bump error", "bump tilt", "asymmetry", "spike",
                    "flipped", "intersecting", "anchor miss", "seconds"]  # fmt: skip
    print()
    order = list(dict.fromkeys(row["case"] for row in others))
    others.sort(key=lambda row: order.index(row["case"]))
    case_table = [table_row(row, case_columns) for row in others]
    reporting.report("handles and checks", case_columns, case_table, arguments.json)
    if arguments.json:
        content = {**json.loads(arguments.json.read_text()), "poses": rows, "means": mean_rows, "cases": others}
        arguments.json.write_text(json.dumps(content, indent=1) + "\n")
    print("\n".join(["", *quality_goals.lines(rows, mean_rows, others)]))


def table_row(row, columns):
    """Values in the order of the columns; "missing" in the first column after the method where it is."""
    at = columns.index("method") + 1
    if "missing" in row:
        return [*(row[column] for column in columns[:at]), "missing", *[""] * (len(columns) - at - 1)]
    return ["" if row.get(column) is None else row[column] for column in columns]


if __name__ == "__main__":
    main(parse())
