# SPDX-License-Identifier: MPL-2.0
"""Clips as bones and weights: errors in percent of the diagonal, and processor time on one thread.

Clips of ../shared/data/poses, and a generated tube of 20 bones that are to be found. The plain version gives each
vertex to one bone (Lloyd's rounds alone). Says so where the clips are missing.
"""

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import mesh_files
from native.benchmarks import reporting, rigid

#: Root mean squares to reach with 20 bones, free and with joints; with 40 bones half of that.
GOALS = {"horse_gallop": (0.17, 0.27), "samba": (0.37, 0.60)}
COLUMNS = ["clip", "vertices", "frames", "bones", "kind", "rms %", "goal", "most %", "CPU s", "plain %", "its CPU s"]


def read_clip(name):
    with np.load(mesh_files.DATA / "poses" / f"{name}.npz") as clip:
        rest = clip["rest"].astype(float)
        return rest, np.concatenate([rest[None], clip["poses"]]).astype(np.float32), clip["faces"]


def measured(rest, frames, **options):
    """(BoneFit, rms and largest error in percent of the diagonal, CPU seconds)."""
    began = time.process_time()
    found = meanvalue.fit_bones(rest, frames, threads=1, **options)
    seconds, percent = time.process_time() - began, 100.0 / np.linalg.norm(np.ptp(rest, axis=0))
    rms = np.sqrt(np.mean(np.square(found.errors, dtype=float)))
    return found, percent * float(rms), percent * float(found.errors.max()), seconds


def clip_rows(name):
    rest, frames, faces = read_clip(name)
    for count in (20, 40):
        plain = measured(rest, frames, count=count, influences=1, joints=False)
        for joints, goal in zip((False, True), GOALS[name], strict=True):
            _, rms, largest, seconds = measured(rest, frames, faces=faces, count=count, joints=joints)
            kind = "joints" if joints else "free"
            case = [name, len(rest), len(frames), count, kind]
            yield [*case, rms, goal * 20 / count, largest, seconds, plain[1], plain[3]]


def planted(bones=20, count=40):
    """(rest, frames, joints (bones - 1, 3)): a tube of `bones` pieces, each turned against the one before."""
    angles, along = np.arange(24) * np.pi / 12, np.linspace(0.0, bones, 20 * bones)
    rest = np.array([[np.cos(a), np.sin(a), 2.0 * z] for z in along for a in angles])
    bone = np.minimum(rest[:, 2] // 2, bones - 1).astype(int)
    rng, frames = np.random.default_rng(1), []
    axes, phases = rng.normal(size=(bones, 3)), rng.uniform(0.0, 6.0, bones)
    for frame in range(count):
        turn, shift, posed = np.eye(3), np.zeros(3), np.empty_like(rest)
        for j in range(bones):
            head = np.array([0.0, 0.0, 2.0 * j])
            own = rigid.rotation_about(axes[j], 25 * np.sin(0.4 * frame + phases[j]))
            own = own @ rigid.rotation_about(axes[j - 1], 15 * np.cos(0.7 * frame + phases[j]))
            turn, shift = turn @ own, turn @ (head - own @ head) + shift
            posed[bone == j] = rest[bone == j] @ turn.T + shift
        frames.append(posed)
    return rest, frames, np.array([[0.0, 0.0, 2.0 * j] for j in range(1, bones)])


def main():
    json_path = reporting.json_argument(__doc__)
    rest, frames, joints = planted()
    found, rms, largest, seconds = measured(rest, frames, count=20)
    size = np.linalg.norm(np.ptp(rest, axis=0))
    off = np.linalg.norm(found.heads[None] - joints[:, None], axis=2).min(axis=1) / size
    rows = [["planted", len(rest), len(frames), 20, "joints", rms, "", largest, seconds, "", ""]]
    print(f"joints of planted bones that are found within 1 % of the size: {(off < 0.01).sum()} of {len(off)}")
    for name in GOALS:
        if (mesh_files.DATA / "poses" / f"{name}.npz").exists():
            rows += clip_rows(name)
        else:
            reporting.missing(f"the clip poses/{name}.npz")
    reporting.report("bones and weights of clips", COLUMNS, rows, json_path)


if __name__ == "__main__":
    main()
