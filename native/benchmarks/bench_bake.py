# SPDX-License-Identifier: MPL-2.0
"""Baking: 300 frames of a moving handle by solve_sequence(), on one thread and on two."""

import argparse
import os
import pathlib
import resource
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import generated_meshes, reporting

COLUMNS = [
    "shape", "vertices", "frames", "one thread s", "two threads s", "times as fast", "frames/s", "goal frames/s",
    "exponent in frames", "peak MB more", "rounds", "same bits",
]  # fmt: skip
GOAL = 1.8
#: Frames a second on two threads, by the number of vertices.
RATES = {10_000: 100.0, 50_000: 25.0}
SHAPES = ("body", "bar")


def trajectories(job, frames):
    """(f, k, 3): the path of the handle to and fro, without the jump at its start."""
    path = job.targets[1:]
    return np.concatenate([path, path[::-1]] * (1 + frames // (2 * len(path))))[:frames]


def solved(deformer, targets, threads):
    """(seconds, processor seconds, digest of the frames): they are handed over and not kept, as when they are written
    to a file."""
    digest = []
    begun, worked = time.perf_counter(), time.process_time()
    deformer.solve_sequence(targets, threads=threads, on_frame=lambda _, shape: digest.append(hash(shape.tobytes())))
    return time.perf_counter() - begun, time.process_time() - worked, tuple(digest)


def measure(shape, vertices, frames, rounds):
    import meanvalue

    job = generated_meshes.speed_job(shape, vertices)
    deformer = meanvalue.Deformer(job.vertices, job.faces, job.anchors, handles=job.pieces + 1)
    targets = trajectories(job, frames)
    seconds, spent = {1: [], 2: []}, {1: [], 2: []}
    digests = set()
    for _ in range(rounds):
        for threads in seconds:
            taken, worked, digest = solved(deformer, targets, threads)
            seconds[threads].append(taken)
            spent[threads].append(worked)
            digests.add(digest)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    twice = solved(deformer, np.concatenate([targets, targets]), 2)[1]
    more = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
    one, two = (float(np.median(seconds[threads])) for threads in seconds)
    # Of processor time: what other work takes away is no growth.
    exponent = np.log(twice / np.median(spent[2])) / np.log(2.0)
    rate = RATES[min(RATES, key=lambda size: abs(np.log(size / vertices)))]
    same = "yes" if len(digests) == 1 else "no"
    return [
        shape, len(job.vertices), frames, one, two, one / two, frames / two, rate, float(exponent), more, rounds, same,
    ]  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--vertices", type=int, nargs="*", default=list(RATES))
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=1)
    arguments = parser.parse_args()
    rows = [
        measure(shape, vertices, arguments.frames, arguments.rounds)
        for vertices in arguments.vertices
        for shape in SHAPES
    ]
    reporting.report(f"baking, {os.cpu_count()} cores", COLUMNS, rows, arguments.json)
    for row in rows:
        name = f"{row[0]}, {row[1]:,} vertices"
        reached = row[5] >= GOAL and row[11] == "yes"
        print(f"{'reached' if reached else 'MISSED '}  {name}: {row[5]:.2f} times as fast on two threads, goal {GOAL}")
        reached = row[6] >= row[7]
        print(f"{'reached' if reached else 'MISSED '}  {name}: {row[6]:.0f} frames a second, goal {row[7]:.0f}")


if __name__ == "__main__":
    main()
