# SPDX-License-Identifier: GPL-3.0-or-later
"""Bound as portable, a mesh is solved with the same bits by every processor, and whatever the C library is made for."""

import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import stress  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]

#: Turns off what glibc chooses other forms of its functions by, as on an older processor.
OLDER = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"

#: Meshes and targets are read, not made: sines and products of numpy are the C library's and the processor's.
PROGRAM = """
import hashlib, math, struct, sys
import numpy as np
import meanvalue
own = hashlib.sha256()
library = hashlib.sha256()
for k in range(20000):
    x = 0.0137 * k
    for function in (math.sin, math.cos, math.tan, math.atan, math.exp):
        library.update(struct.pack("d", function(x / 40.0)))
inputs = np.load(sys.argv[1])
for method, rigidity, size in (("fast", None, 3000), ("fast", 0.4, 600), ("full", None, 300), ("paper", None, 300)):
    points, faces, anchors, pieces, poses = (
        inputs[f"{name}_{size}"] for name in ("points", "faces", "anchors", "pieces", "poses"))
    deformer = meanvalue.Deformer(points, faces, anchors, handles=pieces, method=method, rigidity=rigidity,
                                  portable=True)
    drag = deformer.drag()
    for targets in poses:
        own.update(drag.solve(targets).vertices.tobytes())
print(own.hexdigest(), library.hexdigest())
"""


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    """Bars held at one end; the other is turned by 180, 120 and 60 degrees."""
    arrays = {}
    for size in (3000, 600, 300):
        points, faces = stress.bar(size)
        points = np.asarray(points, np.float64)
        ends = points[:, 0] < points[:, 0].min() + 0.1, points[:, 0] > points[:, 0].max() - 0.1
        anchors = np.flatnonzero(ends[0] | ends[1])
        pieces = ends[1][anchors].astype(np.int32)
        turn = np.array([[0.5, -(0.75**0.5), 0.0], [0.75**0.5, 0.5, 0.0], [0.0, 0.0, 1.0]])
        poses = np.repeat(points[anchors][None], 3, axis=0)
        for pose, times in zip(poses, (3, 2, 1), strict=True):
            pose[pieces == 1] = pose[pieces == 1] @ np.linalg.matrix_power(turn, times).T
        made = {"points": points, "faces": faces, "anchors": anchors, "pieces": pieces, "poses": poses}
        arrays.update({f"{name}_{size}": array for name, array in made.items()})
    path = tmp_path_factory.mktemp("portable") / "inputs.npz"
    np.savez(path, **arrays)
    return path


def digests(tunables, inputs):
    environment = {"PYTHONPATH": os.pathsep.join(path for path in (str(ROOT), *sys.path) if path)}
    if tunables:
        environment["GLIBC_TUNABLES"] = tunables
    ended = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(inputs)],
        capture_output=True,
        text=True,
        timeout=300,
        cwd=ROOT,
        env=environment,
    )
    assert ended.returncode == 0, ended.stderr
    return ended.stdout.split()


@pytest.mark.slow
def test_the_c_library_of_another_processor_does_not_change_a_bit(inputs):
    own, library = digests("", inputs)
    own_older, library_older = digests(OLDER, inputs)
    if library == library_older:
        pytest.skip("the C library rounds alike with and without FMA here, so that nothing is compared")
    assert own == own_older


def test_portable_answers_are_those_of_the_fastest_form_but_for_rounding():
    points, faces = stress.bar(1500)
    points = np.asarray(points, np.float64)
    anchors = np.array([0, len(points) // 2, len(points) - 1])
    targets = points[anchors] + [[0, 0, 0], [0, 0.2, 0], [0, 0, 0.3]]
    first, second = (
        meanvalue.Deformer(points, faces, anchors, portable=portable).solve(targets, tolerance=1e-6).vertices
        for portable in (False, True)
    )
    diagonal = np.linalg.norm(np.ptp(points, axis=0))
    assert np.abs(first - second).max() < 1e-4 * diagonal
