# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a bake on their way: chunks in a folder, each a point cache with a marker beside it that is written last.

A chunk counts only if its marker has the key of what is baked (a digest of all that it depends on), the frames and the
size. So what was killed goes on where it was, changed settings never mix with old chunks, and several processes may
work on one folder without knowing of each other.
"""

import contextlib
import hashlib
import itertools
import pathlib

from ...errors import CacheError, DamagedCacheError, IncompleteCacheError
from ...scene.core import whole_files
from ...scene.core.checked_json import read_checked_json, write_checked_json
from . import point_cache

SCHEMA = 3


class ChunkStore:
    """The chunks of one clip.

    folder    where they are
    key       digest of everything that the frames depend on
    frames    range of the numbers of all frames of the clip; with sub-frames the numbers of the samples
    vertices  of the mesh
    """

    def __init__(self, folder, key, frames, vertices):
        self.folder = pathlib.Path(folder)
        self.key = key
        self.frames = frames
        self.vertices = vertices

    def write(self, first, rows, problems):
        """Keeps the rows (f, n, 3) from frame `first` on, with f texts on what went wrong. @throws CacheError."""
        last = first + len(rows) - 1  # the name is of the frames alone: who bakes the same writes the same file
        path = self.folder / f"{first:+07d}_{last:+07d}.pc2"
        header = point_cache.Header(self.vertices, float(first), 1.0, len(rows))
        point_cache.write(path, header, rows)
        state = hashlib.sha256(header.packed())
        state.update(point_cache.as_bytes(rows))
        marker = {
            "schema": SCHEMA,
            "key": self.key,
            "frames": [first, last],
            "bytes": header.bytes,
            "sha256": state.hexdigest(),
            "vertices": self.vertices,
            "problems": list(problems),
        }
        write_checked_json(path.with_suffix(".json"), marker)

    def missing(self):
        """The frames that are in no chunk, ascending. Reads all markers."""
        return self._without(self._where())

    def merge(self, path, header):
        """Generator that puts the chunks together into the cache `path`, and yields the share that is done.

        Checks that no frame is missing and each chunk is what was written. Returns [text] of all frames, as write()
        was given them.

        @throws IncompleteCacheError, DamagedCacheError, after which the chunk is gone, CacheError.
        """
        where = self._where()
        missing = self._without(where)
        if missing:
            raise IncompleteCacheError(
                f"{len(missing)} of {len(self.frames)} frames are not baked yet, the first is {missing[0]}. Bake them "
                "first"
            )
        problems = []
        with whole_files.replacing(path, header.bytes) as file:
            file.write(header.packed())
            for chunk, frames in itertools.groupby(self.frames, lambda frame: where[frame][0]):
                frames = list(frames)
                marker = where[frames[0]][1]
                begin = frames[0] - marker["frames"][0]
                end = begin + len(frames)
                _copy_checked(chunk, marker, begin, end, file)
                problems += marker["problems"][begin:end]
                yield len(problems) / len(self.frames)
        return problems

    def remove(self):
        """Takes all chunks away, whatever their key, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in sorted(self.folder.glob("*")):
                if path.suffix in {".pc2", ".json"} or ".tmp." in path.name:
                    path.unlink()
            self.folder.rmdir()

    def _without(self, where):
        return [frame for frame in self.frames if frame not in where]

    def _where(self):
        """{frame: (path of the chunk that has it, its marker)}."""
        where = {}
        for path in sorted(self.folder.glob("*.json")):
            marker = read_checked_json(path)  # one that is written at this moment is not there yet
            if marker is None or marker.get("schema") != SCHEMA:
                continue
            if marker["key"] != self.key or marker["vertices"] != self.vertices:
                continue
            chunk = path.with_suffix(".pc2")
            with contextlib.suppress(CacheError):  # as if it were not there: it is solved again
                if point_cache.read_header(chunk).bytes == marker["bytes"]:
                    first, last = marker["frames"]
                    for frame in range(max(first, self.frames[0]), min(last, self.frames[-1]) + 1):
                        where.setdefault(frame, (chunk, marker))
        return where


def _copy_checked(path, marker, begin, end, file):
    """Appends rows [begin, end) of a chunk, all of which is checked. @throws DamagedCacheError."""
    state = hashlib.sha256(point_cache.read_header(path).packed())
    row = 0
    for portion in point_cache.portions(path):
        state.update(point_cache.as_bytes(portion))
        file.write(point_cache.as_bytes(portion[max(0, begin - row) : max(0, end - row)]))
        row += len(portion)
    if state.hexdigest() != marker["sha256"]:
        first, last = marker["frames"]
        for suffix in (".json", ".pc2"):
            path.with_suffix(suffix).unlink(missing_ok=True)
        raise DamagedCacheError(
            f"Frames {first} to {last} in {path} are not what was written (a damaged disk, or another program). They "
            "were taken out: bake again, which solves only them"
        )
