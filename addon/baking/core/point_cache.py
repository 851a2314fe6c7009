# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches in the format PC2: the positions of all vertices, sample after sample.

A file is a header of 32 bytes (POINTCACHE2, version 1, vertices, first frame, frames per sample, samples), then 3
float32 for each vertex of each sample, all little-endian.
"""

import contextlib
import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from ...errors import CacheError, DamagedCacheError
from ...scene.core import whole_files
from ...scene.core.checked_json import read_checked_json, write_checked_json

_LAYOUT = struct.Struct("<12siiffi")
_SIGNATURE = b"POINTCACHE2\0"
_VERSION = 1

#: Rows that are copied at a time take about so much memory.
PORTION_BYTES = 16 << 20


@dataclass(frozen=True)
class Header:
    """start: frame of the first sample; rate: frames from one sample to the next."""

    vertices: int
    start: float
    rate: float
    samples: int

    @property
    def row_bytes(self):
        return 12 * self.vertices

    @property
    def bytes(self):
        """Of the whole file."""
        return _LAYOUT.size + self.samples * self.row_bytes

    def packed(self):
        return _LAYOUT.pack(_SIGNATURE, _VERSION, self.vertices, self.start, self.rate, self.samples)


def write(path, header, rows):
    """Writes a cache of rows (header.samples, header.vertices, 3), which is there only when it is whole.

    @throws CacheError; what stood under the name is then as it was.
    """
    if rows.shape != (header.samples, header.vertices, 3):
        raise ValueError(f"rows of shape {rows.shape} for a cache of {header}")
    with whole_files.replacing(path, header.bytes) as file:
        file.write(header.packed())
        file.write(as_bytes(rows))


def as_bytes(rows):
    rows = np.ascontiguousarray(rows, "<f4")
    return memoryview(rows).cast("B") if rows.size else b""


def read_header(path):
    """The Header of a file of the right length. @throws CacheError, DamagedCacheError."""
    path = pathlib.Path(path)
    with whole_files.telling(path):
        size = path.stat().st_size
        with path.open("rb") as file:
            start = file.read(_LAYOUT.size)
    if len(start) < _LAYOUT.size or not start.startswith(_SIGNATURE):
        raise DamagedCacheError(f"'{path}' is no point cache (PC2). Bake again, or choose another path")
    _, version, vertices, first, rate, samples = _LAYOUT.unpack(start)
    header = Header(vertices, first, rate, samples)
    if version != _VERSION or vertices < 0 or samples < 0 or header.bytes != size:
        raise DamagedCacheError(
            f"'{path}' is damaged: its header tells of {samples:,} samples of {vertices:,} vertices, "
            f"{header.bytes:,} bytes, and it has {size:,}. Bake again"
        )
    return header


def mapped(path):
    """(samples, n, 3) float32 that stay on the disk. @throws CacheError."""
    header = read_header(path)
    shape = (header.samples, header.vertices, 3)
    with whole_files.telling(path):
        return np.memmap(path, "<f4", mode="r", offset=_LAYOUT.size, shape=shape) if np.prod(shape) else np.empty(shape)


def portions(path):
    """Goes through all rows, some at a time: arrays (f, n, 3) float32. @throws CacheError."""
    header = read_header(path)
    count = max(1, PORTION_BYTES // max(1, header.row_bytes))
    with whole_files.telling(path), pathlib.Path(path).open("rb") as file:
        file.seek(_LAYOUT.size)
        for first in range(0, header.samples, count):
            rows = min(count, header.samples - first)
            yield np.fromfile(file, "<f4", 3 * header.vertices * rows).reshape(rows, header.vertices, 3)


def marker_path(path):
    """Beside the cache `path`: a dict that says whose it is, and of what."""
    path = pathlib.Path(path)
    return path.with_name(f"{path.name}.json")


def write_marker(path, about):
    """@throws CacheError."""
    write_checked_json(marker_path(path), about)


def read_marker(path):
    """{} if there is none, or one that anything else has written to."""
    return read_checked_json(marker_path(path)) or {}


def is_current(path, key, header):
    """Whether the cache at `path` is what was baked with this key."""
    with contextlib.suppress(CacheError):
        return read_marker(path).get("key") == key and read_header(path).bytes == header.bytes
    return False
