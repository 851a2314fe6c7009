# SPDX-License-Identifier: MPL-2.0
"""Speed beside the peers: bind, first update, dragging, memory, and how they grow with the mesh.

Two generated shapes (generated_meshes.py), every run in a process of its own, one after the other. A run may do fewer
than the 100 frames: no new frame is begun when its frames took `--frame-seconds`. CPU seconds are the sum
over threads and suffer less from other work on the machine.
"""

import argparse
import json
import os
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import generated_meshes, reporting, shape_metrics
from native.benchmarks.peers import methods

COLUMNS = [
    "shape", "vertices", "method", "bind s", "first update s", "warm median s", "warm worst s", "warm CPU s", "frames",
    "peak MB", "to converged", "to a fresh solve",
]  # fmt: skip
SHAPES = ("body", "bar")
SIZES = (10_000, 50_000, 200_000)
ITERATIONS = 10  # of the peers, an update
LEAST_STEPS = 4  # the jump, the first frame, and two warm ones
CHECKED_STEPS = [0, 20, 100]  # of ours: the jump and two frames
CHECK_UP_TO = 60_000  # vertices
IN_UPDATE = ("open3d", "baseline")  # programs of peers that bind in each update
DEFAULT_OURS = ("fast",)
WARM_RATIO, WARM_AIM, COLD_RATIO, BIND_RATIO, EXPONENT = 10.0, 20.0, 2.0, 2.0, 1.2
GOAL_SIZE = 50_000
MEMORY_AT_A_MILLION = 8e9
CONVERGED = 1e-3  # over the diagonal; beyond it an answer is not called converged


def measure(job, shape, method, arguments):
    """One row as a dictionary by COLUMNS; `missing` tells why figures are not there."""
    row = {"shape": shape, "vertices": len(job.vertices), "method": method.name}
    options = {"frame_seconds": arguments.frame_seconds, "least_steps": LEAST_STEPS}
    if method.is_ours and len(job.vertices) <= CHECK_UP_TO:
        options["check"] = CHECKED_STEPS
    outcome = methods.run(method, job, ITERATIONS, arguments.time_limit, **options)
    if outcome.missing:
        return {**row, "missing": outcome.missing}
    result, warm = outcome.result, np.array(outcome.result["seconds"][2:])
    row.update({
        "bind s": result["bind_seconds"] if method.program not in IN_UPDATE else "in update",
        "first update s": result["seconds"][0], "warm median s": float(np.median(warm)),
        "warm worst s": float(warm.max()), "warm CPU s": float(np.median(result["cpu_seconds"][2:])),
        "frames": len(warm) + 1, "peak MB": result["peak_bytes"] / 1e6,
    })  # fmt: skip
    for column, name in (("to converged", "onwards"), ("to a fresh solve", "afresh")):
        found = [check[name] for check in result.get("checks", {}).values()]
        row[column] = max(found) if found else ""
    row["unconverged"], row["iterations"] = result.get("unconverged", 0), result.get("iterations", [])
    return row


def ratios(rows):
    """Lines: our seconds against CGAL's 10 iterations and libigl's precomputation on the same mesh."""
    lines = []
    for row in rows:
        cgal, libigl = (find(rows, row, name) for name in (methods.CGAL, methods.LIBIGL))
        if row["method"] not in methods.OURS or "missing" in row or not cgal or not libigl:
            continue
        lines.append(
            f"{label(row)}: warm {cgal['warm median s'] / row['warm median s']:.3g} times as fast as CGAL's "
            f"{ITERATIONS} iterations, cold {cgal['first update s'] / row['first update s']:.3g} times; "
            f"bind {row['bind s'] / libigl['bind s']:.3g} times libigl's precomputation"
        )
    return lines


def exponents(rows):
    """{(shape, method): {column: exponent}} over the sizes that ran."""
    found = {}
    for shape, method in dict.fromkeys((row["shape"], row["method"]) for row in rows):
        series = [row for row in rows if (row["shape"], row["method"]) == (shape, method) and "missing" not in row]
        sizes = [row["vertices"] for row in series]
        if len(set(sizes)) > 1:
            found[shape, method] = {
                column: shape_metrics.exponent(sizes, [row[column] for row in series])
                for column in ("bind s", "first update s", "warm median s") if series[0][column] != "in update"
            }  # fmt: skip
    return found


def goals(rows, powers):
    """Lines that say of each goal for our methods whether it was reached."""
    lines = []
    for row in rows:
        if row["method"] not in methods.OURS:
            continue
        if "missing" in row:
            lines.append(goal(False, f"{label(row)}: did not run: {row['missing']}"))
            continue
        if 0.5 * GOAL_SIZE < row["vertices"] < 2 * GOAL_SIZE:
            lines += goals_beside_peers(row, *(find(rows, row, name) for name in (methods.CGAL, methods.LIBIGL)))
        if row["to converged"] != "":
            text = f"{label(row)}: updates within {row['to converged']:.2g} of the converged shape over the diagonal, "
            text += f"{row['to a fresh solve']:.2g} of a solve from rest; {row['unconverged']} said to be unconverged"
            lines.append(goal(row["to converged"] <= CONVERGED, text))
        if row["vertices"] > 900_000:
            text = f"{label(row)}: {row['peak MB']:.0f} MB at most, limit {MEMORY_AT_A_MILLION / 1e6:.0f}"
            lines.append(goal(row["peak MB"] * 1e6 <= MEMORY_AT_A_MILLION, text))
    for (shape, method), by_column in powers.items():
        if method in methods.OURS:
            for column in ("first update s", "warm median s"):
                text = f"{shape}, {method}: {column} grows with exponent {by_column[column]:.3g}, limit {EXPONENT}"
                lines.append(goal(by_column[column] <= EXPONENT, text))
    return lines


def goals_beside_peers(row, cgal, libigl):
    """The goals at 50,000 vertices."""
    lines = []
    if cgal:
        warm, cold = (cgal[column] / row[column] for column in ("warm median s", "first update s"))
        aim = "aim reached" if warm >= WARM_AIM else f"aim {WARM_AIM:g}"
        text = f"{label(row)}: warm {warm:.3g} times as fast as CGAL, goal {WARM_RATIO:g} ({aim})"
        lines.append(goal(warm >= WARM_RATIO, text))
        lines.append(goal(cold >= COLD_RATIO, f"{label(row)}: cold {cold:.3g} times as fast, goal {COLD_RATIO:g}"))
    if libigl:
        bind = row["bind s"] / libigl["bind s"]
        lines.append(goal(bind <= BIND_RATIO, f"{label(row)}: bind {bind:.3g} times libigl's, limit {BIND_RATIO:g}"))
    return lines


def find(rows, like, method):
    """The row of another method on the same mesh, or None where it is missing."""
    for row in rows:
        if (row["shape"], row["vertices"], row["method"]) == (like["shape"], like["vertices"], method):
            return None if "missing" in row else row
    return None


def label(row):
    return f"{row['shape']} {row['vertices']}, {row['method']}"


def goal(reached, text):
    return f"{'reached' if reached else 'MISSED '}  {text}"


def table_row(row):
    """Values by COLUMNS; the reason instead of figures where it is missing."""
    if "missing" in row:
        return [row["shape"], row["vertices"], row["method"], "missing", *[""] * (len(COLUMNS) - 4)]
    return [row[column] for column in COLUMNS]


def size(text):
    """10k, 1m or a plain number."""
    scale = {"k": 1_000, "m": 1_000_000}.get(text[-1].lower(), 1)
    return int(float(text.rstrip("kKmM")) * scale)


def parse():
    """The arguments."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--sizes", default=SIZES, help="as in 10k,50k,200k,1m (default: without 1m)",
                        type=lambda text: [size(part) for part in text.split(",")])  # fmt: skip
    parser.add_argument("--shapes", default=SHAPES, type=lambda text: text.split(","))
    parser.add_argument("--ours", default=DEFAULT_OURS, type=lambda text: text.split(";"),
                        help=f"our methods, by semicolons: {'; '.join(methods.OURS)}")  # fmt: skip
    parser.add_argument("--only", choices=["ours", "peers"])
    parser.add_argument("--peers", default=list(methods.PEERS), type=lambda text: text.split(";"),
                        help=f"by semicolons: {'; '.join(methods.PEERS)}")  # fmt: skip
    parser.add_argument("--frame-seconds", type=float, default=6.0)
    parser.add_argument("--time-limit", type=float, default=240.0, help="seconds for one run")
    return parser.parse_args()


def main(arguments):
    """Measures, prints, writes."""
    chosen = [] if arguments.only == "peers" else [methods.OURS[name] for name in arguments.ours]
    chosen += [] if arguments.only == "ours" else [methods.PEERS[name] for name in arguments.peers]
    load = os.getloadavg()[0]  # of the last minute: other work on the machine
    rows = []
    for shape in arguments.shapes:
        for vertex_count in arguments.sizes:
            job = generated_meshes.speed_job(shape, vertex_count)
            for method in chosen:
                rows.append(measure(job, shape, method, arguments))
                print(f"{label(rows[-1])}: {rows[-1].get('missing') or 'done'}", flush=True)
    for row in rows:
        if "missing" in row:
            reporting.missing(f"{label(row)}: {row['missing']}")
    title = f"speed; an update of a peer is {ITERATIONS} iterations; peak MB of the process; load before: {load:.1f}"
    reporting.report(title, COLUMNS, [table_row(row) for row in rows], arguments.json)
    powers = exponents(rows)
    if arguments.json:
        content = json.loads(arguments.json.read_text())
        content["measured"] = rows
        content["exponents"] = [{"shape": key[0], "method": key[1], **value} for key, value in powers.items()]
        arguments.json.write_text(json.dumps(content, indent=1) + "\n")
    print()
    for (shape, method), by_column in powers.items():
        print(f"exponent: {shape}, {method}: " + ", ".join(f"{k} {v:.3g}" for k, v in by_column.items()))
    print("\n".join(["", *ratios(rows), "", *goals(rows, powers)]))


if __name__ == "__main__":
    main(parse())
