# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that a bake samples, and how much it makes of them."""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core.whole_files import in_bytes
from . import point_cache

#: What is larger asks first.
LARGE_BYTES = 1_000_000_000
MANY_KEYS = 500

#: Memory of a shape key, for each vertex: positions, and the copy that Blender evaluates.
KEY_BYTES_PER_VERTEX = 24


def sample_times(start, end, step=1, samples=1):
    """f float64: frames from `start` to at most `end`, `step` apart, `samples` for each step. @throws SceneError."""
    if end < start:
        raise SceneError(f"The range ends before it begins (frames {start} to {end}). Exchange Start and End")
    count = (end - start) * samples // step + 1
    return start + np.arange(count) * step / samples


def spacing(step, samples):
    """Frames from one sample to the next."""
    return step / samples


def rows_of(times, first, last):
    """(begin, end) of the samples from frame `first` to `last`. @throws SceneError if there are none."""
    inside = np.flatnonzero((times >= first) & (times <= last))
    if len(inside) == 0:
        raise SceneError(
            f"Frames {first} to {last} are not in the range that is baked, {named(times[0])} to {named(times[-1])}"
        )
    return int(inside[0]), int(inside[-1]) + 1


def size_problem(samples, vertices, keys=None):
    """A sentence if the bake would hurt, else None. keys: how many shape keys at most; None for a point cache."""
    if keys is None:
        size = point_cache.Header(vertices, 0.0, 1.0, samples).bytes
        if size <= LARGE_BYTES:
            return None
        return (
            f"The point cache of {samples:,} samples of {wording.vertices(vertices)} will take {in_bytes(size)}, and "
            "as much again while it is put together"
        )
    size = keys * vertices * KEY_BYTES_PER_VERTEX
    if keys <= MANY_KEYS and size <= LARGE_BYTES:
        return None
    return (
        f"{wording.counted(keys, 'shape key')} of {wording.vertices(vertices)} will take {in_bytes(size)} of memory, "
        f"{in_bytes(size // 2)} in the file, and slow Blender down. A point cache has no such limits"
    )


def named(time):
    """A frame as names and messages show it: "12", "12.5"."""
    return f"{time:.3f}".rstrip("0").rstrip(".") if time % 1 else f"{time:.0f}"
