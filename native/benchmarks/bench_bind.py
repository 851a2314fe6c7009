# SPDX-License-Identifier: MPL-2.0
"""Binding again: one more handle on a mesh that is bound already, beside a first bind with the same anchors.

Whole meshes, all free but for their handles. Both are made in turns, so that other work on the machine slows both.
"""

import argparse
import pathlib
import statistics
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from native.benchmarks import generated_meshes, reporting

COLUMNS = [
    "shape", "vertices", "method", "first s", "again s", "ratio", "first CPU s", "again CPU s", "CPU ratio", "same",
]  # fmt: skip
SHAPES = ("body", "bar")
GOAL = 1 / 3
HANDLE = 100  # vertices of the handle that is added
TURNS = 5


def with_one_more(job, turn):
    """(anchors, targets) with a handle about another vertex at each turn, moved a little."""
    taken = np.isin(np.arange(len(job.vertices)), job.anchors)
    centre = np.random.default_rng(turn).choice(np.flatnonzero(~taken))
    nearest = np.argsort(np.linalg.norm(job.vertices - job.vertices[centre], axis=1))[:HANDLE]
    more = nearest[~taken[nearest]]
    shift = 0.02 * np.ptp(job.vertices, axis=0).max()
    targets = np.concatenate([job.vertices[job.anchors], job.vertices[more] + shift])
    return np.concatenate([job.anchors, more]).astype(np.int32), targets


def measured(action):
    """(seconds, CPU seconds of all threads, result)."""
    begun, cpu_begun = time.perf_counter(), time.process_time()
    result = action()
    return time.perf_counter() - begun, time.process_time() - cpu_begun, result


def measure(shape, vertex_count, method, threads):
    """One row of the table."""
    job = generated_meshes.speed_job(shape, vertex_count)
    options = {"method": method, "threads": threads}
    earlier = meanvalue.Deformer(job.vertices, job.faces, job.anchors, **options)
    first, again, is_same = [], [], True
    for turn in range(TURNS):
        anchors, targets = with_one_more(job, turn)
        *seconds, fresh = measured(lambda: meanvalue.Deformer(job.vertices, job.faces, anchors, **options))  # noqa: B023
        first.append(seconds)
        *seconds, rebound = measured(lambda: earlier.rebind(anchors))  # noqa: B023
        again.append(seconds)
        if turn == 0:
            is_same = np.array_equal(fresh.solve(targets).vertices, rebound.solve(targets).vertices)
    (first_s, first_cpu), (again_s, again_cpu) = (
        [statistics.median(column) for column in zip(*rows, strict=True)] for rows in (first, again)
    )
    return [shape, len(job.vertices), method, first_s, again_s, again_s / first_s, first_cpu, again_cpu,
            again_cpu / first_cpu, is_same]  # fmt: skip


def main():
    """Measures, prints, writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--vertices", type=int, default=50_000)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--methods", default=("fast",), type=lambda text: text.split(","))
    arguments = parser.parse_args()
    rows = [
        measure(shape, arguments.vertices, method, arguments.threads)
        for shape in SHAPES
        for method in arguments.methods
    ]
    title = f"bind again with one handle more; medians of {TURNS}; goal {GOAL:.2g} of a first bind"
    reporting.report(title, COLUMNS, rows, arguments.json)


if __name__ == "__main__":
    main()
