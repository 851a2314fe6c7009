# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads a motion capture file of any known format."""

import os
import pathlib

from ...errors import MotionFileError
from . import bvh_file, c3d_file, trc_file
from .recording import Take

_READERS = {".c3d": c3d_file.read, ".trc": trc_file.read, ".bvh": bvh_file.read}

#: What `read()` knows, by the file's suffix in lower case.
SUFFIXES = tuple(_READERS)


def read(path: str | os.PathLike, *, up_axis: str | None = None, unit: float | None = None) -> Take:
    """The markers in a C3D, TRC or BVH file, as a Take.

    `up_axis`: which of the file's axes points up, one of units.UP_AXES; None: as the file says. `unit`: meters for
    one unit of the file; None: as the file says. Where the file is silent, a plausible guess is made and told in the
    notes.
    Raises MotionFileError with the file's name, the reason and a remedy for whatever can't be read.
    """
    return read_by(_READERS, path, up_axis, unit)


def read_by(readers, path, *options):
    """What the one of readers, {suffix: function of (bytes, name, *options)}, for the suffix of a file makes of it.

    Raises as read().
    """
    path, wanted = pathlib.Path(path), f"one of {', '.join(readers)}"
    reader = readers.get(path.suffix.lower())
    try:
        if path.is_dir():
            raise MotionFileError(f"{path}: this is a folder. Choose a file in it: {wanted}")
        if reader is None:
            raise MotionFileError(f"{path.name}: what ends in '{path.suffix}' is not read. Export it as {wanted}")
        if not path.is_file():  # a pipe or a device would never end
            raise MotionFileError(f"{path}: there is no such file. Choose {wanted}")
        return reader(path.read_bytes(), path.name, *options)
    except OSError as error:
        raise MotionFileError(f"{path}: it cannot be opened ({error.strerror}). Check its permissions") from None
    except MemoryError:
        raise MotionFileError(f"{path}: the memory is too small for this file. Export a shorter range") from None
