# SPDX-License-Identifier: MPL-2.0
"""A drag in Blender as fast as a hand makes it: what a step costs, and how near what is shown is to the settled shape.

Runs itself in Blender without a window. A control moves 60 times a second, from rest and right after binding, and turns
by 36 degrees a second; between steps timers tick, as in the interface. A step counts as shown if the mesh is where the
control is when the next one comes, by an answer or by a draft. Distances are root mean squares over the diagonal: the
largest of some steps of the first half second, and of the next.

Large meshes can be posed while they are being bound: the same hand, from when Live is turned on, and how long it takes
until a draft is shown, and an answer.
"""

import itertools
import os
import pathlib
import statistics
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import bench_live, reporting

COLUMNS = ["mesh", "vertices", "step ms", "worst ms", "steps", "shown", "off at first", "off later", "solve ms"]
CASES = (("body", 50_000), ("body", 200_000), ("bar", 200_000))
PRESS_COLUMNS = ["mesh", "vertices", "first draft s", "first answer s"]
PRESS_CASES = (("body", 200_000), ("body", 1_000_000))
STEPS, STEP_SECONDS, TICK_SECONDS = range(1, 60), 1.0 / 60.0, 0.003
AT_FIRST, LATER = range(3, 30, 3), range(30, 60, 5)
GOALS_MS = {50_000: 22.0, 200_000: 70.0}
MOST_OFF = 2e-3
PRESS_GOAL_S = 4.0


class Hand:
    """Drags the handle of a bench_live.Scene."""

    def __init__(self, shape, size):
        self.scene = bench_live.Scene(shape, size)
        self.follower, self.obj = self.scene.follower, self.scene.obj

    def step(self, number):
        """Moves the control and does what is due until the next move. Returns seconds of work, and whether it is
        shown."""
        began = time.perf_counter()
        self.scene.place(number)
        self.follower.follow(self.obj)
        self.scene.evaluate()
        self.scene.tell()
        worked = time.perf_counter() - began
        while time.perf_counter() - began < STEP_SECONDS:
            time.sleep(TICK_SECONDS)
            began_tick = time.perf_counter()
            self.follower.tick(self.obj)
            self.scene.evaluate()
            worked += time.perf_counter() - began_tick
        is_drafted = self.follower._drag.drafted is self.follower._wanted
        return worked, is_drafted or self.scene.is_caught_up()

    def shown(self):
        """n x 3 positions of the result key."""
        return self.scene.parts["scene.shape_keys"].held(self.obj, self.obj.meanvalue.result_key).copy()

    def settled(self, number):
        """The same once all is settled at a step."""
        self.scene.place(number)
        self.follower.follow(self.obj)
        self.scene.settle()
        return self.shown()


def measure(shape, size):
    """One row."""
    hand = Hand(shape, size)
    hand.scene.bind()
    seconds, shown, shapes = [], 0, {}
    for number in STEPS:
        worked, is_shown = hand.step(number)
        seconds.append(worked)
        shown += is_shown
        if number in AT_FIRST or number in LATER:
            shapes[number] = hand.shown()
    solve = hand.follower.solve_seconds
    hand.scene.settle()
    diagonal = float(np.linalg.norm(np.ptp(hand.scene.vertices, axis=0)))

    def off(numbers):
        differences = [hand.settled(number) - shapes[number] for number in numbers]
        return max(float(np.sqrt(np.mean(np.square(each).sum(axis=1)))) for each in differences) / diagonal

    count, step, worst = len(hand.scene.vertices), statistics.median(seconds), max(seconds)
    return [shape, count, 1e3 * step, 1e3 * worst, len(STEPS), shown, off(AT_FIRST), off(LATER), 1e3 * solve]


def press(shape, size):
    """One row of PRESS_COLUMNS."""
    hand = Hand(shape, size)
    began, first_draft = time.perf_counter(), None
    for number in itertools.cycle(STEPS):
        hand.step(number)
        passed = time.perf_counter() - began
        if first_draft is None and hand.follower._drag.drafted is not None:
            first_draft = passed
        if hand.follower.solve_seconds > 0.0 or hand.follower.problem is not None:
            break
    return [shape, len(hand.scene.vertices), first_draft or passed, passed]


def main():
    import bpy

    sys.argv = [sys.argv[0], *sys.argv[sys.argv.index("--") + 1 :]]
    json_path = reporting.json_argument(__doc__)
    bpy.ops.preferences.addon_install(filepath=os.environ["MEANVALUE_ADDON_ZIP"], overwrite=True)
    rows = [measure(*case) for case in CASES]
    presses = [press(*case) for case in PRESS_CASES]
    reporting.report(f"dragging, Blender {bpy.app.version_string}", COLUMNS, rows, json_path)
    reporting.report("posing while a mesh is bound", PRESS_COLUMNS, presses, json_path)
    for (shape, size), row in zip(CASES, rows, strict=True):
        bench_live.judge(f"{shape}, {size:,} vertices: {row[2]:.1f} ms a step", row[2], GOALS_MS[size], "ms")
        for name, off in zip(("at first", "later"), row[6:8], strict=True):
            bench_live.judge(f"{shape}, {size:,} vertices: {off:.1e} off the settled shape {name}", off, MOST_OFF, "")
    for (shape, size), row in zip(PRESS_CASES, presses, strict=True):
        bench_live.judge(f"{shape}, {size:,} vertices: first draft after {row[2]:.1f} s", row[2], PRESS_GOAL_S, "s")


if __name__ == "__main__":
    if "bpy" in sys.modules:
        main()
    else:
        sys.exit(bench_live.run_in_blender(sys.argv[1:], __file__))
