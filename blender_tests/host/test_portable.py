# SPDX-License-Identifier: GPL-3.0-or-later
"""Bound as portable, a mesh is solved with the same bits by every processor, and whatever the C library is made for."""

import os
import subprocess
import sys

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support import portable_bits, stress  # noqa: E402

#: Turns off what glibc chooses other forms of its functions by, as on an older processor.
OLDER = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable,-FMA4_Usable"


@pytest.fixture(scope="module")
def inputs(tmp_path_factory):
    path = tmp_path_factory.mktemp("portable") / "inputs.npz"
    portable_bits.make(path)
    return path


def digests(tunables, inputs):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    if tunables:
        environment["GLIBC_TUNABLES"] = tunables
    command = [sys.executable, portable_bits.__file__, "digest", str(inputs)]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment)
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
