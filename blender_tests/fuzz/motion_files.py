# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture/ read from bytes: whole files to damage, and what must come of a damaged one."""

import pathlib

import numpy as np

from addon.capture.core import bvh_file, c3d_file, table_file
from addon.errors import MotionFileError
from blender_tests.support import capture_files, walker
from blender_tests.support.mesh_files import DATA

READERS = {".c3d": c3d_file.read, ".trc": table_file.read, ".bvh": bvh_file.read, ".csv": table_file.read}

METRES = walker.positions(3)
MILLIMETRES = 1000.0 * walker.with_gaps(METRES, (1, 1, 2))
MOVES = ("Xposition", "Yposition", "Zposition", "Zrotation", "Yrotation", "Xrotation")
FIGURE = ("Hips", (0, 0, 0), MOVES, [("Head", (0, 60, 0), MOVES[3:], [(None, (0, 20, 0), (), [])])])
TABLE = "frame,time,left hip x,left hip y,left hip z,right hip x,right hip y,right hip z,nose_x,nose_y,nose_z"
TABLE += "\n0,0.00,1.25,2.5,12.0,1,2,3,4,5,6\n1,0.01,,,,4,5,6,7,8,9\n2,0.02,1.5,2.75,12.25,1.5,2.5,3.5,4.5,5.5,6.5\n"


def small_files():
    """(name, content) of a file of each format: a few kilobytes."""
    outputs = {"ANGLES": ["HEAD"], "TYPE_GROUPS": ["ANGLES", "ANGLE"]}
    motion = np.round(np.random.default_rng(2).uniform(-90.0, 90.0, (3, 9)), 3)
    return [
        ("small.c3d", capture_files.c3d(walker.LABELS[:3], MILLIMETRES[:, :3], analog=2, point=outputs)),
        ("small.trc", capture_files.trc(walker.LABELS[:3], MILLIMETRES[:, :3], decimals=2)),
        ("small.bvh", capture_files.bvh(FIGURE, motion)),
        ("small.csv", TABLE.encode()),
    ]


def larger_files():
    """The same with more in it, in all number formats, and the real files where they are."""
    positions = 1000.0 * walker.with_gaps(walker.positions(40), (1, 3, 30), (4, 0, 5))
    groups = {"TRIAL": {"ACTUAL_START_FIELD": [1, 0], "ACTUAL_END_FIELD": [40, 0]}, "SUBJECTS": {"NAMES": ["A", "B"]}}
    files = [
        (
            f"{processor}{scale}.c3d",
            capture_files.c3d(walker.LABELS, positions, processor=processor, scale=scale, analog=8, groups=groups),
        )
        for processor in ("PC", "DEC", "SGI")
        for scale in (-0.1, 0.1)
    ]
    files.append(("walk.trc", capture_files.trc(walker.LABELS, positions)))
    files.append(("walk.bvh", capture_files.bvh(FIGURE, np.round(np.random.default_rng(4).normal(size=(40, 9)), 4))))
    real = [path for path in sorted((DATA / "mocap").glob("*/*")) if path.suffix.lower() in READERS]
    return files + [(path.name, path.read_bytes()) for path in real if path.stat().st_size < 100_000]


def attempt(name, content):
    """True if `content` gave a Take, which is then as Takes are; False if it was refused. Anything else fails."""
    try:
        take = READERS[pathlib.Path(name).suffix.lower()](content, name)
    except MotionFileError as error:
        assert str(error).startswith(name) and len(str(error)) < 500
        return False
    frames, markers, three = take.positions.shape
    assert frames > 0 and markers > 0 and three == 3 and take.positions.dtype == np.float64
    assert len(take.labels) == markers == len(set(take.labels)) and all(take.labels)
    assert np.isfinite(take.rate_hz) and take.rate_hz > 0.0
    missing = np.isnan(take.positions)
    assert np.array_equal(missing.any(axis=2), missing.all(axis=2)) and not missing.all()
    assert np.nanmax(np.abs(take.positions)) <= 1e4
    return True
