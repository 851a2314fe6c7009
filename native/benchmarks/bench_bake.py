# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking: 300 frames of a moving handle on one bound mesh, by one thread and by two with half of the frames each."""

import argparse
import pathlib
import sys
import threading
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import generated_meshes, reporting

COLUMNS = ["shape", "vertices", "frames", "one thread s", "two threads s", "times as fast", "rounds", "same bits"]
GOAL = 1.8
SHAPES = ("body", "bar")


def in_chunks(deformer, targets, rest, threads):
    """(f, n, 3): thread k solves the k-th part of the frames, each from the one before, the first from rest."""
    shapes = np.empty((len(targets), *rest.shape))

    def bake(frames):
        shape = None
        for frame in frames:
            shape = deformer.solve(targets[frame], start=shape).vertices
            shapes[frame] = shape

    parts = np.array_split(np.arange(len(targets)), threads)
    workers = [threading.Thread(target=bake, args=(part,)) for part in parts]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return shapes


def measure(shape, vertices, frames, rounds):
    import meanvalue

    job = generated_meshes.speed_job(shape, vertices)
    deformer = meanvalue.Deformer(job.vertices, job.faces, job.anchors, handles=job.pieces + 1, threads=1)
    path = job.targets[1:]  # without the jump; to and fro
    targets = np.concatenate([path, path[::-1]] * (1 + frames // (2 * len(path))))[:frames]
    seconds = {1: [], 2: []}
    first_half = {}
    for _ in range(rounds):
        for threads in seconds:
            begun = time.perf_counter()
            shapes = in_chunks(deformer, targets, job.vertices, threads)
            seconds[threads].append(time.perf_counter() - begun)
            first_half[threads] = shapes[: frames // 2]
    one, two = (float(np.median(seconds[threads])) for threads in seconds)
    same = np.array_equal(first_half[1], first_half[2])
    return [shape, len(job.vertices), frames, one, two, one / two, rounds, "yes" if same else "no"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--vertices", type=int, default=10_000)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    rows = [measure(shape, arguments.vertices, arguments.frames, arguments.rounds) for shape in SHAPES]
    reporting.report("baking side by side", COLUMNS, rows, arguments.json)
    for row in rows:
        told = "reached" if row[5] >= GOAL and row[7] == "yes" else "MISSED "
        print(f"{told}  {row[0]}: {row[5]:.2f} times as fast, goal {GOAL}; same bits: {row[7]}")


if __name__ == "__main__":
    main()
