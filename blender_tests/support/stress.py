# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds, solves, cancels and numpy's products from several threads at once, each compared bit by bit with a run alone.

A program of its own, since what goes wrong may end the process: its last line is what stress() returns, as JSON.
"""

import argparse
import json
import pathlib
import random
import sys
import threading
import time
from collections import Counter
from dataclasses import dataclass, field

import numpy as np

if __name__ == "__main__":
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from native.benchmarks.generated_meshes import bar, body
from native.benchmarks.rigid import rotation_about

POSES = 3
PRODUCT_SIZE = 300  # large enough for the blocked kernels of a BLAS


@dataclass
class Case:
    """One mesh with its anchors and options, the poses to solve, and what they give where nothing else runs."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    anchors: np.ndarray
    targets: list
    options: dict
    solve_options: dict
    expected: list = field(default_factory=list)

    def bind(self, **more):
        return meanvalue.Deformer(self.vertices, self.faces, self.anchors, **self.options, **more)

    def start_bind(self, **more):
        return meanvalue.start_bind(self.vertices, self.faces, self.anchors, **self.options, **more)


def held_bar(vertex_count, share=0.08):
    """(vertices, faces, anchors, pieces): what is within a share of the length of either side is a handle."""
    points, faces = bar(vertex_count)
    along = (points[:, 0] - points[:, 0].min()) / np.ptp(points[:, 0])
    anchors = np.flatnonzero((along < share) | (along > 1.0 - share)).astype(np.int32)
    return points, faces, anchors, (along[anchors] > 0.5).astype(np.int32)


def case(name, vertices, faces, *, solve=None, **options):
    """Its lowest and highest parts are anchors; the upper one turns, rises and leans."""
    height = (vertices[:, 2] - vertices[:, 2].min()) / np.ptp(vertices[:, 2])
    anchors = np.flatnonzero((height < 0.05) | (height > 0.95)).astype(np.int32)
    upper = height[anchors] > 0.5
    rest = vertices[anchors]
    centre = rest[upper].mean(axis=0)
    targets = []
    for pose in range(1, POSES + 1):
        turn, posed = rotation_about((1, 0, 0), 23.0 * pose), rest.copy()
        shift = 0.1 * pose * np.ptp(vertices[:, 0]) * np.eye(3)[pose % 3]
        posed[upper] = (rest[upper] - centre) @ turn.T + centre + shift
        targets.append(posed)
    return Case(name, vertices, faces, anchors, targets, options, solve or {})


def made_cases():
    """Small enough for hundreds of rounds in half a minute; those above 3,000 vertices have coarse levels."""
    small, middle, large = bar(1500), body(4000), body(8000)
    return [
        case("bar, fast", *small),
        case("bar, fast, rigidity 0", *small, rigidity=0.0),
        case("bar, full", *small, method="full", solve={"max_iterations": 4}),
        case("bar, paper", *small, method="paper"),
        case("body, fast", *middle, rigidity=100.0),
        case("body, paper", *middle, method="paper"),
        case("large body, fast", *large),
    ]


class Alone:
    """What everything gives where nothing else runs; to be made before the first thread is started."""

    def __init__(self, cases):
        self.cases = cases
        self.shared = {one.name: one.bind(threads=2) for one in cases}
        for one in cases:
            one.expected = [self.shared[one.name].solve(posed, **one.solve_options) for posed in one.targets]
        self.factors = np.random.default_rng(1).standard_normal((2, PRODUCT_SIZE, PRODUCT_SIZE))
        self.product = self.factors[0] @ self.factors[1]


class Worker:
    """One thread: rounds of randomly chosen work, on deformers of its own and on those that all share."""

    # numpy's products exclude each other: whether its BLAS bears two of them is not what is looked at here.
    multiplying = threading.Lock()

    def __init__(self, alone, rounds, seed, until):
        self.alone, self.rounds, self.until = alone, rounds, until
        self.random = random.Random(seed)
        self.own = {}  # case name: a deformer for many solves
        self.done = Counter()
        self.wrong = []
        self.thread = threading.Thread(target=self.run)

    def run(self):
        actions = [self.bind_and_solve, self.solve_kept, self.tasks, self.cancel_bind, self.cancel_solve, self.multiply]
        for _ in range(self.rounds):
            if time.monotonic() > self.until:
                return
            one, action = self.random.choice(self.alone.cases), self.random.choice(actions)
            try:
                action(one)
            except Exception as error:
                self.wrong.append(f"{one.name}, {action.__name__}: {type(error).__name__}: {error}")
            self.done[action.__name__] += 1

    def compare(self, one, pose, solution, what):
        expected = one.expected[pose]
        if not np.array_equal(solution.vertices, expected.vertices) or solution.energies != expected.energies:
            off = np.abs(solution.vertices - expected.vertices).max() / np.linalg.norm(np.ptp(one.vertices, axis=0))
            self.wrong.append(f"{one.name}, {what}: other bits than alone, off by {off:.2g} diagonals")

    def threads(self):
        return self.random.choice([1, 2, 3])

    def bind_and_solve(self, one):
        pose = self.random.randrange(POSES)
        solution = one.bind(threads=self.threads()).solve(one.targets[pose], **one.solve_options)
        self.compare(one, pose, solution, "bind and solve")

    def kept(self, one):
        if self.random.random() < 0.5:
            return self.alone.shared[one.name]
        if one.name not in self.own:
            self.own[one.name] = one.bind(threads=self.threads())
        return self.own[one.name]

    def solve_kept(self, one):
        deformer = self.kept(one)
        for pose in range(POSES):
            self.compare(one, pose, deformer.solve(one.targets[pose], **one.solve_options), "solve again")

    def tasks(self, one):
        deformer = one.start_bind(threads=self.threads()).result()
        pose = self.random.randrange(POSES)
        task = deformer.start_solve(one.targets[pose], **one.solve_options)
        self.multiply(one)
        self.compare(one, pose, task.result(), "tasks")

    def cancel_bind(self, one):
        execution = meanvalue.Execution()
        task = one.start_bind(threads=self.threads(), execution=execution)
        self.cancelled_at_any_time(task, execution)

    def cancel_solve(self, one):
        execution = meanvalue.Execution()
        task = self.kept(one).start_solve(one.targets[0], **one.solve_options, execution=execution)
        self.cancelled_at_any_time(task, execution)
        self.solve_kept(one)

    def cancelled_at_any_time(self, task, execution):
        task.wait(0.05 * self.random.random() ** 2)
        execution.cancel()
        try:
            task.result()
        except meanvalue.Cancelled:
            self.done["cancelled"] += 1

    def multiply(self, _):
        with self.multiplying:
            product = self.alone.factors[0] @ self.alone.factors[1]
        if not np.array_equal(product, self.alone.product):
            self.wrong.append(f"numpy's product: off by {np.abs(product - self.alone.product).max():.2g}")


def stress(alone, threads, rounds, seconds, seed=1):
    """`rounds` in all, shared out to so many threads; fewer where they take longer than `seconds`."""
    start = time.monotonic()
    workers = [Worker(alone, -(-rounds // threads), 1000 * seed + k, start + seconds) for k in range(threads)]
    for worker in workers:
        worker.thread.start()
    for worker in workers:
        worker.thread.join()
    counts = sum((worker.done for worker in workers), Counter())
    rounds, wrong = counts.total() - counts["cancelled"], [each for worker in workers for each in worker.wrong]
    return {"threads": threads, "rounds": rounds, "seconds": time.monotonic() - start, "done": counts, "wrong": wrong}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, nargs="+", default=[2, 4, 6])
    parser.add_argument("--rounds", type=int, default=100, help="for each number of threads")
    parser.add_argument("--seconds", type=float, default=600.0, help="the most for each number of threads")
    arguments = parser.parse_args()
    alone = Alone(made_cases())
    for threads in arguments.threads:
        print(json.dumps(stress(alone, threads, arguments.rounds, arguments.seconds)), flush=True)


if __name__ == "__main__":
    main()
