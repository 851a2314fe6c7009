# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches in the format PC2: the positions of all vertices, sample after sample.

A file is a header of 32 bytes (POINTCACHE2, version 1, vertices, first frame, frames per sample, samples), then 3
float32 for each vertex of each sample, all little-endian.
"""

import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from ...errors import CacheError, DamagedCacheError
from ...scene.core import whole_files

_LAYOUT = struct.Struct("<12siiffi")
_SIGNATURE = b"POINTCACHE2\0"
_VERSION = 1

#: Rows that are copied or read at a time take about so much memory.
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


def write(path, header, portions):
    """Writes a cache, which is there only when it is whole. portions: arrays (f, n, 3), in all header.samples rows.

    @throws CacheError; what stood under the name is then as it was.
    """
    with whole_files.replacing(path, header.bytes) as file:
        file.write(header.packed())
        rows = 0
        for portion in portions:
            file.write(_bytes_of(portion, header))
            rows += len(portion)
        if rows != header.samples:
            raise ValueError(f"{rows} rows for a cache of {header.samples}")


def write_again(path, first_row, portions):
    """Rows from `first_row` on are written anew, in a copy that takes the place of the file when it is whole.

    @throws CacheError, and ValueError if the rows do not fit.
    """
    header = read_header(path)
    with whole_files.replacing(path, header.bytes) as file, pathlib.Path(path).open("rb") as old:
        for part in _pieces(old):
            file.write(part)
        file.seek(_LAYOUT.size + first_row * header.row_bytes)
        row = first_row
        for portion in portions:
            if first_row < 0 or row + len(portion) > header.samples:
                raise ValueError(f"rows {row} to {row + len(portion)} of a cache of {header.samples}")
            file.write(_bytes_of(portion, header))
            row += len(portion)


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


def read_rows(path, begin, end):
    """(end - begin, n, 3) float32: samples of a cache. @throws CacheError."""
    header = read_header(path)
    if not 0 <= begin <= end <= header.samples:
        raise CacheError(f"'{path}' has {header.samples:,} samples; {begin} to {end} were asked for")
    with whole_files.telling(path), pathlib.Path(path).open("rb") as file:
        file.seek(_LAYOUT.size + begin * header.row_bytes)
        values = np.fromfile(file, "<f4", 3 * header.vertices * (end - begin))
    return values.reshape(end - begin, header.vertices, 3)


def mapped(path, samples, vertices):
    """(samples, vertices, 3) float32 of a cache, which stay on the disk."""
    return np.memmap(path, "<f4", mode="r", offset=_LAYOUT.size, shape=(samples, vertices, 3))


def portions(path):
    """Goes through all rows of a cache, some at a time: arrays (f, n, 3) float32."""
    header = read_header(path)
    count = max(1, PORTION_BYTES // max(1, header.row_bytes))
    for begin in range(0, header.samples, count):
        yield read_rows(path, begin, min(begin + count, header.samples))


def _bytes_of(portion, header):
    rows = np.ascontiguousarray(portion, "<f4")
    if rows.shape[1:] != (header.vertices, 3):
        raise ValueError(f"rows of shape {rows.shape} for a cache of {header.vertices} vertices")
    return memoryview(rows).cast("B") if rows.size else b""


def _pieces(file):
    while piece := file.read(PORTION_BYTES):
        yield piece
