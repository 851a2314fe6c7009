# SPDX-License-Identifier: MPL-2.0
"""Markers against the truth: a captured dancer of whom 41 vertices are taken as markers, complete and with gaps.

Root mean square of the distance of all vertices in all frames, over that of converged ARAP with the same anchors and
nothing missing. Says so where the dancer is missing.
"""

import argparse
import pathlib
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from addon.capture.core import gaps  # noqa: E402
from blender_tests.support import mesh_files  # noqa: E402
from native.benchmarks import reporting  # noqa: E402

COLUMNS = ["markers", "missing", "strength", "rms over diagonal", "over ARAP's", "goal", "frames/s", "not converged"]
MARKERS = 41
COMPLETE_GOAL = 0.70
GAPS_GOAL = 0.80
LONGEST_GAP = 20
MISSING_SHARE = 0.10
#: Gaps of at most so many of the 24 frames are filled by splines, up to the second number by the neighbours' motion.
LONGEST_SPLINE = 4
LONGEST_RIGID = 8
DANCER = mesh_files.DATA / "poses" / "samba.npz"


def farthest_points(points, count):
    """(count,) vertex numbers, each the farthest from those before it."""
    chosen = [int(np.argmax(np.linalg.norm(points - points.mean(axis=0), axis=1)))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen, np.int32)


def with_gaps(trajectories, seed):
    """The same with MISSING_SHARE of the samples NaN, in gaps of up to LONGEST_GAP frames."""
    random = np.random.default_rng(seed)
    holed = trajectories.copy()
    frames, markers = holed.shape[:2]
    while np.isnan(holed[..., 0]).mean() < MISSING_SHARE:
        length = int(random.integers(1, LONGEST_GAP + 1))
        begin = int(random.integers(0, max(1, frames - length + 1)))
        holed[begin : begin + length, random.integers(markers)] = np.nan
    return holed


def root_mean_square(shapes, truth):
    return float(np.sqrt(((shapes - truth) ** 2).sum(axis=2).mean()))


def measure(arguments):
    import meanvalue

    data = np.load(DANCER)
    rest, truth = data["rest"].astype(np.float64), data["poses"].astype(np.float64)
    faces = data["faces"].astype(np.int32)
    diagonal = float(np.linalg.norm(np.ptp(rest, axis=0)))
    anchors = farthest_points(rest, MARKERS)
    trajectories = truth[:, anchors]
    arap = np.array(
        [meanvalue.baselines.arap(rest, faces, anchors, posed) for posed in trajectories]
    )
    error_of_arap = root_mean_square(arap, truth)
    rows = []

    def add(name, missing, strength, deformer, targets, weights, goal):
        begun = time.perf_counter()
        result = deformer.solve_sequence(targets, weights=weights)
        rate = len(targets) / (time.perf_counter() - begun)
        error = root_mean_square(result.vertices, truth)
        failed = int((~result.converged).sum())
        rows.append([name, missing, strength, error / diagonal, error / error_of_arap, goal, rate, failed])

    add("hard", 0.0, "", meanvalue.Deformer(rest, faces, anchors), trajectories, None, COMPLETE_GOAL)
    for strength in arguments.strengths:
        soft = meanvalue.Deformer(rest, faces, anchors, strengths=np.full(MARKERS, strength))
        add("soft", 0.0, strength, soft, trajectories, None, COMPLETE_GOAL)
        for seed in range(arguments.seeds):
            holed = with_gaps(trajectories, seed)
            share = float(np.isnan(holed[..., 0]).mean())
            free = (~np.isnan(holed[..., 0])).astype(float)
            add(f"soft, gaps {seed}, freed", share, strength, soft, holed, free, GAPS_GOAL)
            filled = gaps.fill_gaps(holed, LONGEST_SPLINE, LONGEST_RIGID)
            known = (~np.isnan(filled[..., 0])).astype(float)
            add(f"soft, gaps {seed}, filled", share, strength, soft, filled, known, GAPS_GOAL)
    return rows, error_of_arap / diagonal


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--strengths", type=float, nargs="*", default=[1.0])
    arguments = parser.parse_args()
    if not DANCER.exists():
        reporting.missing("the dancer, poses/samba.npz")
        return
    rows, error_of_arap = measure(arguments)
    reporting.report(f"markers of a dancer; ARAP {error_of_arap:.5f} of the diagonal", COLUMNS, rows, arguments.json)
    for row in rows:
        told = "reached" if row[4] <= row[5] else "MISSED "
        print(f"{told}  {row[0]}, strength {row[2] or 'hard'}: {row[4]:.3f}, goal {row[5]}")
    for how in ("freed", "filled"):
        ratios = [row[4] for row in rows if row[0].endswith(how)]
        if ratios:
            print(f"gaps, {how}: mean of {len(ratios)} rows {np.mean(ratios):.3f}, median {np.median(ratios):.3f}")


if __name__ == "__main__":
    main()
