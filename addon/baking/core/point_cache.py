# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches in the format PC2: a header of 32 bytes (POINTCACHE2, version 1, vertices, first frame, frames per
sample, samples), then 3 float32 for each vertex of each sample, all little-endian."""

import contextlib
import glob
import json
import os
import pathlib
import struct
from dataclasses import dataclass

import numpy as np

from ...errors import CacheError, DamagedCacheError
from ...scene.core import whole_files

_LAYOUT = struct.Struct("<12siiffi")
_SIGNATURE = b"POINTCACHE2\0"
_VERSION = 1


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
        return self.offset(self.samples)

    def offset(self, sample):
        """Where a sample begins."""
        return _LAYOUT.size + sample * self.row_bytes

    def packed(self):
        return _LAYOUT.pack(_SIGNATURE, _VERSION, self.vertices, self.start, self.rate, self.samples)


def read_header(path):
    """The Header of a file of the right length. @throws CacheError, DamagedCacheError."""
    with whole_files.telling(path), pathlib.Path(path).open("rb") as file:
        start = file.read(_LAYOUT.size)
        size = file.seek(0, os.SEEK_END)
    if len(start) == _LAYOUT.size:
        signature, version, *about = _LAYOUT.unpack(start)
        header = Header(*about)
        is_whole = header.bytes == size and min(header.vertices, header.samples) >= 0
        if is_whole and (signature, version) == (_SIGNATURE, _VERSION):
            return header
    raise DamagedCacheError(f"'{path}' is no whole point cache (PC2). Bake again, or choose another path")


def mapped(path):
    """(samples, n, 3) float32 that stay on the disk. @throws CacheError."""
    header = read_header(path)
    with whole_files.telling(path):
        return np.memmap(path, "<f4", "r", _LAYOUT.size, (header.samples, header.vertices, 3))


def marker_path(path):
    """Beside the cache `path`: a dict that says whose it is, and of what."""
    path = pathlib.Path(path)
    return path.with_name(f"{path.name}.json")


def write_marker(path, about):
    """@throws CacheError."""
    with whole_files.replacing(marker_path(path)) as file:
        file.write(json.dumps(about).encode())


def read_marker(path):
    """{} if there is none that makes sense."""
    try:
        about = json.loads(marker_path(path).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return about if isinstance(about, dict) else {}


def is_current(path, key, header):
    """Whether the cache at `path` is what was baked with this key."""
    with contextlib.suppress(CacheError):
        return read_marker(path).get("key") == key and read_header(path).bytes == header.bytes
    return False


class Begun:
    """A cache that is being written, in a file beside its own: what was killed goes on behind what is whole of it. Its
    name has the key of what is baked: changed settings never go on with the samples of others.

    path      where it is until all samples are there
    problems  [text] on each of the samples that are whole: what went wrong, or ""
    """

    def __init__(self, path, key, header):
        self._whole, self._header = path, header
        self.path = path.with_name(f"{path.name}.{key[:16]}.part")  # paths of Windows are short
        self.problems = read_marker(self.path).get("problems")
        if not isinstance(self.problems, list) or not self._has(len(self.problems)):
            self.problems = []

    def _has(self, samples):
        return self.path.exists() and self.path.stat().st_size >= self._header.offset(samples)

    def _require_all(self):
        if self.problems and not self._has(len(self.problems)):
            raise DamagedCacheError(f"What was begun of '{self._whole}' is finished elsewhere, or deleted. Bake again")

    def write(self, begin, rows, problems):
        """Keeps rows (r, n, 3), of the samples from `begin` on, with r texts. @throws CacheError."""
        with whole_files.telling(self.path):
            self._require_all()
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.path.touch()
            with self.path.open("r+b") as file:
                file.write(self._header.packed())
                file.seek(self._header.offset(begin))
                file.write(np.asarray(rows, "<f4").tobytes())
                file.flush()
                os.fsync(file.fileno())
        self.problems[begin:] = problems
        write_marker(self.path, {"problems": self.problems})

    def become_whole(self):
        """@throws CacheError."""
        with whole_files.telling(self._whole):
            self._require_all()
            whole_files.rename(self.path, self._whole)
        self.remove()

    def remove(self):
        """Takes away what was begun of this cache, with whatever key."""
        for left in self._whole.parent.glob(f"{glob.escape(self._whole.name)}.*.part*"):
            with contextlib.suppress(OSError):
                left.unlink()
