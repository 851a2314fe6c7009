# SPDX-License-Identifier: GPL-3.0-or-later
"""What meshes that are bound as portable are solved to, as a digest of bits, to compare systems and processors by.

portable_bits.py make FILE      writes meshes and targets: sines and products of numpy are the C library's and the
                                processor's, so that others read them
portable_bits.py digest FILE    prints the digest of the answers, and that of the C library's own functions
"""

import hashlib
import math
import pathlib
import struct
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
from blender_tests.support import stress

SIZES = (3000, 600, 300)
#: Method, rigidity, size, and which of the arrays are given besides.
BOUND = (
    ("fast", None, 3000, ()),
    ("fast", 0.4, 600, ()),
    ("full", None, 300, ()),
    ("paper", None, 300, ()),
    ("fast", None, 300, ("strengths",)),
    ("fast", None, 600, ("examples",)),
)
NAMES = ("points", "faces", "anchors", "pieces", "poses", "strengths", "examples")
EXAMPLES = 3  # with the functions that these are mixed by more than Eigen factors as one block


def make(path):
    """Bars held at one end; the other is turned by 180, 120 and 60 degrees, or soft. Examples are twisted bars."""
    arrays = {}
    for size in SIZES:
        points, faces, anchors, pieces = stress.held_bar(size, 0.05)
        turn = np.array([[0.5, -(0.75**0.5), 0.0], [0.75**0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
        poses = np.repeat(points[anchors][None], 3, axis=0)
        for pose, times in zip(poses, (3, 2, 1), strict=True):
            pose[pieces == 1] = pose[pieces == 1] @ np.linalg.matrix_power(turn, times).T
        strengths = np.where(pieces == 1, 0.5, np.inf)
        examples = [twisted(points, number + 1.0) for number in range(EXAMPLES)]
        made = (points, faces, anchors, pieces, poses, strengths, examples)
        arrays.update({f"{name}_{size}": array for name, array in zip(NAMES, made, strict=True)})
    np.savez(path, **arrays)


def twisted(points, angle_rad):
    """The same, turned about x by as much from one end to the other."""
    angles = angle_rad * (points[:, 0] - points[:, 0].min()) / np.ptp(points[:, 0])
    _, y, z = points.T
    return np.stack([points[:, 0], y * np.cos(angles) - z * np.sin(angles), y * np.sin(angles) + z * np.cos(angles)], 1)


def digest_of_answers(path):
    import meanvalue

    found, inputs = hashlib.sha256(), np.load(path)
    for method, rigidity, size, more in BOUND:
        points, faces, anchors, pieces, poses, *_ = (inputs[f"{name}_{size}"] for name in NAMES)
        given = {name: inputs[f"{name}_{size}"] for name in more}
        deformer = meanvalue.Deformer(
            points, faces, anchors, handles=pieces, method=method, rigidity=rigidity, portable=True, **given
        )
        drag = deformer.drag()
        for number, targets in enumerate(poses):
            weights = np.where(pieces == 1, 0.5**number, 1.0) if "strengths" in more else None
            found.update(drag.solve(targets, weights=weights).vertices.tobytes())
    return found.hexdigest()


def digest_of_library():
    found = hashlib.sha256()
    for k in range(20000):
        x = 0.0137 * k
        for function in (math.sin, math.cos, math.tan, math.atan, math.exp):
            found.update(struct.pack("d", function(x / 40.0)))
    return found.hexdigest()


if __name__ == "__main__":
    task, file = sys.argv[1:]
    if task == "make":
        make(file)
    else:
        print(digest_of_answers(file), digest_of_library())
