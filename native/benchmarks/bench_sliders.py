# SPDX-License-Identifier: MPL-2.0
"""Values of shape keys found from markers on a face: mean error of a value, and frames a second.

Random mixes of 8 shapes of ../shared/data/poses/ict_face.npz at 0.2 to 1; markers by farthest points; the head turns by
about 20 degrees. Says so where that file is missing.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import mesh_files
from native.benchmarks import reporting, rigid

MIXES, SHAPES_OF_MIX = 60, 8
MILLIMETER = 0.1  # of the file's centimeters
LARGEST_OUTLIER = 15 * MILLIMETER
LEAST_OFFSET = 1 * MILLIMETER  # of vertices that may be markers
#: Mean errors that the method is to reach with 60 markers, by noise in millimeters.
GOALS = {0.0: 0.005, 0.3: 0.035, 1.0: 0.07}


def read_face():
    with np.load(mesh_files.DATA / "poses" / "ict_face.npz") as face:
        return face["rest"].astype(float), face["deltas"].astype(float), [str(name) for name in face["names"]]


def markers(rest, deltas, names, count):
    """Vertex numbers, the farthest from each other, of the skin that moves: not of the eyes."""
    skin = [number for number, name in enumerate(names) if not name.startswith(("eyeLook", "Pupil"))]
    moves = np.flatnonzero(np.linalg.norm(deltas[skin], axis=2).max(axis=0) > LEAST_OFFSET)
    chosen, points = [0], rest[moves]
    distances = np.linalg.norm(points - points[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(distances.argmax()))
        distances = np.minimum(distances, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return moves[chosen]


def mixes(fit_shapes, rest, anchors, noise, gaps, outliers):
    """(values (f, s), targets (f, k, 3))."""
    rng = np.random.default_rng(1)
    values = np.zeros((MIXES, len(fit_shapes)))
    targets = np.empty((MIXES, len(anchors), 3))
    for row, of_frame in enumerate(values):
        of_frame[rng.choice(len(of_frame), SHAPES_OF_MIX, replace=False)] = rng.uniform(0.2, 1, SHAPES_OF_MIX)
        shape = rest[anchors] + np.tensordot(of_frame, fit_shapes[:, anchors], 1)
        targets[row] = shape @ rigid.rotation_about(rng.normal(size=3), 20).T + rng.normal(size=3)
    targets += rng.normal(size=targets.shape) * noise * MILLIMETER
    wrong = rng.random(targets.shape[:2]) < outliers
    targets[wrong] += rng.normal(size=(wrong.sum(), 3)) * LARGEST_OUTLIER
    targets[rng.random(targets.shape[:2]) < gaps] = np.nan
    return values, targets


def motion(values, frames=240):
    """(f, s): from one mix to the next, smoothly."""
    places = np.linspace(0, len(values) - 1, frames)
    low = np.minimum(places.astype(int), len(values) - 2)
    share = (0.5 - 0.5 * np.cos(np.pi * (places - low)))[:, None]
    return (1 - share) * values[low] + share * values[low + 1]


def error_rows(rest, deltas, names):
    for count in (60, 20):
        anchors = markers(rest, deltas, names, count)
        fit = meanvalue.SliderFit(rest, rest + deltas, anchors)
        for noise, goal in GOALS.items():
            row = [count, noise]
            for gaps, outliers in ((0, 0), (0.1, 0.02)):
                values, targets = mixes(deltas, rest, anchors, noise, gaps, outliers)
                seconds, found = time.perf_counter(), [fit.solve(frame).values for frame in targets]
                seconds = time.perf_counter() - seconds
                row.append(float(np.abs(np.array(found) - values).mean()))
            yield [*row, goal if count == 60 else "", 1e3 * seconds / MIXES]


def sequence_rows(rest, deltas, names):
    deltas = deltas[np.argsort([name.startswith(("eyeLook", "Pupil")) for name in names], kind="stable")][:50]
    anchors = markers(rest, deltas, [""] * 50, 60)
    fit = meanvalue.SliderFit(rest, rest + deltas, anchors)
    for noise in GOALS:
        values, _ = mixes(deltas, rest, anchors, noise, 0, 0)
        values = motion(values[:5])
        targets = np.array([rest[anchors] + np.tensordot(of_frame, deltas[:, anchors], 1) for of_frame in values])
        targets += np.random.default_rng(2).normal(size=targets.shape) * noise * MILLIMETER
        seconds, found = reporting.median_seconds(lambda: fit.solve_sequence(targets).values, 3)  # noqa: B023
        alone = np.array([fit.solve(frame).values for frame in targets])
        jitter = [float(np.abs(np.diff(of, 2, axis=0)).mean()) for of in (found, alone, values)]
        errors = [float(np.abs(of - values).mean()) for of in (found, alone)]
        yield [noise, *errors, *jitter, len(values) / seconds]


def main():
    json_path = reporting.json_argument(__doc__)
    if not (mesh_files.DATA / "poses" / "ict_face.npz").exists():
        reporting.missing("the face, poses/ict_face.npz")
        return
    face = read_face()
    columns = ["markers", "noise, mm", "error", "with 10 % gaps, 2 % outliers", "goal", "ms a solve"]
    reporting.report("Mean error of a value, each frame by itself", columns, list(error_rows(*face)), json_path)
    columns = ["noise, mm", "error", "each alone", "second differences", "each alone", "of the truth", "frames/s"]
    reporting.report("A motion of 240 frames, 60 markers, 50 shapes", columns, list(sequence_rows(*face)), json_path)


if __name__ == "__main__":
    main()
