# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a motion capture file of any known format."""

from __future__ import annotations

import os

from ...errors import MotionFileError
from .take import Take

#: What `read()` knows, by the file's suffix in lower case.
SUFFIXES = (".c3d", ".trc", ".bvh")
UP_AXES = ("X", "Y", "Z", "-X", "-Y", "-Z")


def read(path: str | os.PathLike, *, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The markers in a C3D, TRC or BVH file, as a Take.

    `up_axis`: which of the file's axes points up, one of UP_AXES; None: as the file says. `unit`: metres for one unit of
    the file; None: as the file says. Where the file is silent, a plausible guess is made and told in the notes.
    Raises MotionFileError with the file's name, the reason and a remedy for whatever can't be read.
    """
    raise MotionFileError(f"{path}: no reader yet")
