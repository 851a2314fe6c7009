# SPDX-License-Identifier: MPL-2.0
"""Dragging real models by few handles, beside CGAL's spokes and rims.

The whole mesh is free. "single": nine single vertices far from each other are held; "patches": six patches, each one
handle. The handle farthest out is carried sideways by 0.15 of the diagonal and turned by 40 degrees, every frame
solved from the last answer (drag_cases.py). "ends", with --tube: a tube, the bar and the body of bench_speed.
CGAL does 10 iterations a frame on the same mesh; it runs before and after ours, in processes of their own as ours is,
and its seconds a frame are the median of both. Energies are what is minimised, over the diagonal squared; at the end of
the drag it is compared with that of a solve of the same targets from rest, and `apart` is the largest distance between
the two shapes over the diagonal.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import drag_cases, reporting
from native.benchmarks.peers import methods
from native.benchmarks.peers.job import RESTART, Job

ITERATIONS = 10  # of CGAL, a frame
CGAL_FRAMES = 3  # in each of its two runs
LEAST_STEPS = drag_cases.FRAMES_FROM + 2
COLD_COLUMNS = [
    "model", "vertices", "set-up", "anchors", "bind s", "first s", "first energy", "first iterations", "last s",
    "last energy", "last iterations", "CGAL s", "first/CGAL", "last/CGAL",
]  # fmt: skip
WARM_COLUMNS = [
    "model", "vertices", "set-up", "frames", "median ms", "worst ms", "iterations", "most", "converged", "CGAL ms",
    "median/CGAL", "worst/CGAL", "energy/cold", "apart", "missed",
]  # fmt: skip
COLD_KEYS = ["model", "vertices", "setup", "anchors", "bind s", "cold first s", "cold first energy",
             "cold first iterations", "cold last s", "cold last energy", "cold last iterations", "CGAL s",
             "cold first/CGAL", "cold last/CGAL"]  # fmt: skip
WARM_KEYS = ["model", "vertices", "setup", "frames", "median ms", "worst ms", "median iterations", "most iterations",
             "converged", "CGAL ms", "median/CGAL", "worst/CGAL", "energy/cold", "apart", "missed"]  # fmt: skip
MEDIAN_GOAL = {drag_cases.SINGLE: 1 / 5, drag_cases.PATCHES: 1 / 10, drag_cases.ENDS: 1 / 25}
GOALS = {"worst/CGAL": 1.0, "cold first/CGAL": 1.0, "cold last/CGAL": 1.0, "energy/cold": 1.02}
SHORT = {"median/CGAL": "median", "worst/CGAL": "worst", "cold first/CGAL": "first", "cold last/CGAL": "last",
         "energy/cold": "energy"}  # fmt: skip


def measure(model, setup, arguments):
    """One row as a dictionary; `missing` tells why there are no figures of ours, `no CGAL` why there are none of it."""
    job = drag_cases.job(model, setup, arguments.frames)
    row = {"model": model.name, "vertices": len(model.vertices), "setup": setup, "anchors": len(job.anchors)}
    before = [] if arguments.no_peers else cgal_seconds(job, row, arguments)
    method = methods.OURS["fast, handles" if setup == drag_cases.PATCHES else "fast"]
    options = {"frame_seconds": arguments.frame_seconds, "least_steps": LEAST_STEPS, "beside_cold": True}
    outcome = methods.run(method, job, ITERATIONS, arguments.time_limit, **options)
    after = cgal_seconds(job, row, arguments) if before else []
    if outcome.missing:
        return {**row, "missing": outcome.missing}
    fill_in(row, job, outcome.result)
    if before or after:
        add_ratios(row, float(np.median(before + after)))
    row["missed"] = ", ".join(missed(row)) or "none"
    return row


def fill_in(row, job, result):
    """Our own figures."""
    start = drag_cases.FRAMES_FROM
    energies = np.array(result["energies"]) / job.diagonal**2
    seconds, iterations = np.array(result["seconds"]), result["iterations"]
    row["bind s"] = result["bind_seconds"]
    for name, step in (("first", drag_cases.FIRST), ("last", drag_cases.LAST)):
        row[f"cold {name} s"], row[f"cold {name} energy"] = float(seconds[step]), float(energies[step])
        row[f"cold {name} iterations"] = iterations[step]
        row[f"cold {name} converged"] = result["converged"][step]
    frames = len(seconds) - start
    row["frames"], row["asked"] = frames, len(job.plan) - start
    row["median ms"], row["worst ms"] = 1e3 * float(np.median(seconds[start:])), 1e3 * float(seconds[start:].max())
    row["median iterations"], row["most iterations"] = float(np.median(iterations[start:])), max(iterations[start:])
    row["converged"] = f"{sum(result['converged'][start:])}/{frames}"
    row["frame ms"] = [1e3 * value for value in seconds[start:]]
    row["frame CPU ms"] = [1e3 * value for value in result["cpu_seconds"][start:]]
    row["frame iterations"], row["frame energies"] = iterations[start:], energies[start:].tolist()
    row["energy/cold"] = result["energies"][-1] / result["cold_energy"]  # of the last frame done
    row["apart"] = result["cold_distance"]


def cgal_seconds(job, row, arguments):
    """A list: seconds of CGAL's warm frames; empty where it has none, and the row says why."""
    held, vertex_count, triangle_count = drag_cases.for_peer(job)
    if vertex_count or triangle_count:
        row["CGAL without"] = f"{vertex_count} vertices without an anchor in their part, {triangle_count} triangles"
    chosen = [drag_cases.AT_REST, *range(drag_cases.FRAMES_FROM, drag_cases.FRAMES_FROM + 1 + CGAL_FRAMES)]
    targets = held.targets[[step for step in chosen if step < len(held.targets)]]
    plan = np.zeros(len(targets), np.int32)
    plan[0] = RESTART
    plain = Job(held.vertices, held.faces, held.anchors, held.pieces, targets, plan)
    outcome = methods.run(methods.PEERS[methods.CGAL], plain, ITERATIONS, arguments.time_limit)
    if outcome.missing:
        row["no CGAL"] = outcome.missing
        return []
    row.setdefault("CGAL CPU ms", []).extend(1e3 * value for value in outcome.result["cpu_seconds"][2:])
    row["CGAL bind s"] = outcome.result["bind_seconds"]
    return outcome.result["seconds"][2:] or outcome.result["seconds"][1:]


def add_ratios(row, cgal):
    """Ours over CGAL's seconds a frame."""
    row["CGAL s"], row["CGAL ms"] = cgal, 1e3 * cgal
    for name in ("median", "worst"):
        row[f"{name}/CGAL"] = row[f"{name} ms"] / row["CGAL ms"]
    for name in ("cold first", "cold last"):
        row[f"{name}/CGAL"] = row[f"{name} s"] / cgal


def missed(row):
    """Names of the goals that a row misses."""
    limits = {"median/CGAL": MEDIAN_GOAL[row["setup"]], **GOALS}
    names = [SHORT[name] for name, limit in limits.items() if row.get(name, 0.0) > limit]
    return [*names, *(["frames"] if row["frames"] < row["asked"] else [])]


def goal_lines(rows):
    """Of each set-up, how many rows reach each goal, and the row that is worst at it."""
    lines = []
    for setup in dict.fromkeys(row["setup"] for row in rows):
        measured = [row for row in rows if row["setup"] == setup and "missing" not in row]
        for name, limit in {"median/CGAL": MEDIAN_GOAL[setup], **GOALS}.items():
            having = [row for row in measured if name in row]
            if not having:
                continue
            reached, worst = sum(row[name] <= limit for row in having), max(having, key=lambda row: row[name])
            mark = "reached" if reached == len(having) else "MISSED "
            lines.append(f"{mark}  {setup}: {name} at most {limit:.3g}: {reached} of {len(having)}; "
                         f"worst {worst[name]:.3g} ({worst['model']})")  # fmt: skip
    return lines


def notes(rows):
    """What is missing, and why."""
    lines = []
    for row in rows:
        place = f"{row['model']}, {row['setup']}"
        if "missing" in row:
            lines.append(f"{place}: {row['missing']}")
        elif row["frames"] < row["asked"]:
            lines.append(f"{place}: only {row['frames']} of {row['asked']} frames in the time")
        if "no CGAL" in row:
            lines.append(f"{place}: CGAL, {row['no CGAL']}")
        if "CGAL without" in row:
            lines.append(f"{place}: CGAL without {row['CGAL without']}")
    return lines


def table_row(row, keys):
    """Values by keys; "missing" after the set-up where there are none."""
    if "missing" in row:
        return [row["model"], row["vertices"], row["setup"], "missing", *[""] * (len(keys) - 4)]
    return [row.get(key, "") for key in keys]


def parse():
    """The arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    usual = ",".join(drag_cases.USUAL)
    parser.add_argument("--models", type=lambda text: text.split(","), help=f"without endings (default: {usual})")
    parser.add_argument("--messy", action="store_true", help="the messy models too")
    parser.add_argument("--tube", action="store_true", help="the tube, the body and the bar too, by their ends")
    parser.add_argument("--setups", default=[drag_cases.SINGLE, drag_cases.PATCHES, drag_cases.ENDS],
                        type=lambda text: text.split(","), help="of single,patches,ends (default: all)")  # fmt: skip
    parser.add_argument("--frames", type=int, default=40, help="of a drag; the whole way is the same")
    parser.add_argument("--no-peers", action="store_true", help="without CGAL, and so without ratios")
    parser.add_argument("--frame-seconds", type=float, default=60.0, help="no frame is begun when a run took that")
    parser.add_argument("--time-limit", type=float, default=240.0, help="seconds for one run")
    return parser.parse_args()


def main(arguments):
    """Measures, prints, writes."""
    load = os.getloadavg()[0]  # of the last minute: other work on the machine
    if not arguments.no_peers:
        methods.build_cgal_quietly()
    rows = []
    for model in drag_cases.models(arguments.models, arguments.messy, arguments.tube):
        for setup in (setup for setup in model.setups if setup in arguments.setups):
            rows.append(measure(model, setup, arguments))
            print(f"{model.name}, {setup}: {rows[-1].get('missing') or 'missed: ' + rows[-1]['missed']}", flush=True)
    for note in notes(rows):
        reporting.missing(note)
    title = f"drag, {arguments.frames} frames; CGAL: {ITERATIONS} iterations a frame; load before: {load:.1f}"
    warm = [table_row(row, WARM_KEYS) for row in rows]
    reporting.report(f"{title}; warm", WARM_COLUMNS, warm, arguments.json)
    print()
    reporting.report(f"{title}; from rest", COLD_COLUMNS, [table_row(row, COLD_KEYS) for row in rows], arguments.json)
    if arguments.json:
        content = {**json.loads(arguments.json.read_text()), "measured": rows}
        arguments.json.write_text(json.dumps(content, indent=1) + "\n")
    print("\n".join(["", *goal_lines(rows)]))


if __name__ == "__main__":
    main(parse())
