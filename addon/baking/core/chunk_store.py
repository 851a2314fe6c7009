# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a bake on their way: chunks in a folder, each a point cache with a marker beside it that is written last.

A chunk counts only if its marker has the key of what is baked (a digest of all that it depends on), the frames and the
size. So what was killed goes on where it was, changed settings never mix with old chunks, and several processes may
work on one folder without knowing of each other.
"""

import contextlib
import hashlib
import pathlib

import numpy as np

from ...errors import DamagedCacheError, IncompleteCacheError
from ...scene.core import whole_files
from ...scene.core.checked_json import read_checked_json, write_checked_json
from . import frame_ranges, point_cache

SCHEMA = 2


class ChunkStore:
    """The chunks of one clip.

    folder    where they are
    key       digest of everything that the frames depend on
    frames    numbers of all frames of the clip, ascending; with sub-frames the numbers of the samples
    vertices  of the mesh
    """

    def __init__(self, folder, key, frames, vertices):
        self.folder = pathlib.Path(folder)
        self.key = key
        self.frames = list(frames)
        self.vertices = vertices

    def write(self, frames, rows, report):
        """Keeps the rows (f, n, 3) of `frames`, with `report`: {name: list of f values}. @throws CacheError."""
        header = point_cache.Header(self.vertices, float(frames[0]), 1.0, len(frames))
        data = np.ascontiguousarray(rows, "<f4")
        runs = frame_ranges.runs(frames)  # the name is of the frames alone: who bakes the same writes the same file
        path = self.folder / (".".join(f"{first:+07d}_{last:+07d}" for first, last in runs) + ".pc2")
        point_cache.write(path, header, [data])
        state = hashlib.sha256(header.packed())
        state.update(memoryview(data).cast("B") if data.size else b"")
        marker = {
            "schema": SCHEMA,
            "key": self.key,
            "frames": frame_ranges.spelled(frames),
            "bytes": header.bytes,
            "sha256": state.hexdigest(),
            "vertices": self.vertices,
            "report": report,
        }
        write_checked_json(path.with_suffix(".json"), marker)

    def has(self, frames):
        """Whether each of `frames` is in a chunk."""
        return set(frames) <= self._where().keys()

    def missing(self):
        """The frames that are in no chunk, ascending."""
        where = self._where()
        return [frame for frame in self.frames if frame not in where]

    def merge(self, path, header):
        """Generator that puts the chunks together into the cache `path`, and yields how many rows are written.

        Checks that no frame is missing and each chunk is what was written. Returns {name: values of all frames} of the
        reports. @throws IncompleteCacheError, DamagedCacheError, after which the chunk is gone, CacheError.
        """
        where = self._require_all()
        reports = self.reports()
        with whole_files.replacing(path, header.bytes) as file:
            file.write(header.packed())
            done = 0
            for name, frames in self._stretches(where):
                marker = self._require_marker(name)
                begin = frame_ranges.parse(marker["frames"]).index(frames[0])
                self._copy_checked(name, marker, (begin, begin + len(frames)), file)
                done += len(frames)
                yield done
        return reports

    def rows(self):
        """Row k of the clip by `rows()[k]`, (n, 3) float32; rows stay on the disk. @throws IncompleteCacheError."""
        return _Rows(self, self._require_all())

    def reports(self):
        """{name: values of all frames} of the reports. @throws IncompleteCacheError."""
        reports = {}
        for name, frames in self._stretches(self._require_all()):
            marker = self._require_marker(name)
            first = frame_ranges.parse(marker["frames"]).index(frames[0])
            for what, values in marker["report"].items():
                reports.setdefault(what, []).extend(values[first : first + len(frames)])
        return reports

    def remove(self):
        """Takes all chunks away, whatever their key, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in sorted(self.folder.glob("*")):
                if path.suffix in {".pc2", ".json"} or ".tmp." in path.name:
                    path.unlink()
            self.folder.rmdir()

    def chunk_of(self, name):
        """(frames, (f, n, 3) float32 that stay on the disk) of a chunk. @throws IncompleteCacheError, CacheError."""
        frames = frame_ranges.parse(self._require_marker(name)["frames"])
        path = self.folder / f"{name}.pc2"
        with whole_files.telling(path):
            return frames, point_cache.mapped(path, len(frames), self.vertices)

    def _copy_checked(self, name, marker, rows, file):
        """Appends rows [begin, end) of a chunk, all of which is checked. @throws DamagedCacheError."""
        path = self.folder / f"{name}.pc2"
        state = hashlib.sha256()
        row = 0
        with whole_files.telling(path):
            state.update(point_cache.read_header(path).packed())
            for portion in point_cache.portions(path):
                state.update(memoryview(portion).cast("B"))
                wanted = portion[max(0, rows[0] - row) : max(0, rows[1] - row)]
                row += len(portion)
                if len(wanted):
                    file.write(memoryview(np.ascontiguousarray(wanted)).cast("B"))
        if state.hexdigest() != marker["sha256"]:
            for suffix in (".json", ".pc2"):
                path.with_suffix(suffix).unlink(missing_ok=True)
            raise DamagedCacheError(
                f"Frames {marker['frames']} in {path} are not what was written (a damaged disk, or another program). "
                "They were taken out: bake again, which solves only them"
            )

    def _require_all(self):
        """As _where(). @throws IncompleteCacheError."""
        where = self._where()
        missing = frame_ranges.spelled([frame for frame in self.frames if frame not in where])
        if missing:
            few = missing if len(missing) <= 60 else missing[:60].rsplit(",", 1)[0] + ", ..."
            raise IncompleteCacheError(f"Frames are not baked yet: {few}. Bake them first")
        return where

    def _where(self):
        """{frame: name of the chunk that has it}."""
        wanted = set(self.frames)
        where = {}
        for path in sorted(self.folder.glob("*.json")):
            marker = _read_marker(path)  # one that is written at this moment is not there yet
            if marker is None or marker["key"] != self.key or marker["vertices"] != self.vertices:
                continue
            with contextlib.suppress(OSError):
                if path.with_suffix(".pc2").stat().st_size == marker["bytes"]:
                    for frame in wanted.intersection(frame_ranges.parse(marker["frames"])):
                        where.setdefault(frame, path.stem)
        return where

    def _stretches(self, where):
        """(name of a chunk, ascending frames that follow each other in it), in the order of the clip."""
        found = []
        for frame in self.frames:
            if found and found[-1][0] == where[frame] and found[-1][1][-1] == frame - 1:
                found[-1][1].append(frame)
            else:
                found.append((where[frame], [frame]))
        return found

    def _require_marker(self, name):
        """Of a chunk that was there a moment ago. @throws IncompleteCacheError."""
        marker = _read_marker(self.folder / f"{name}.json")
        if marker is None:
            raise IncompleteCacheError(f"A part of the bake, {name}, is gone from {self.folder} meanwhile. Bake again")
        return marker


def _read_marker(path):
    marker = read_checked_json(path)
    return marker if marker is not None and marker.get("schema") == SCHEMA else None


class _Rows:
    """The rows of a ChunkStore as a sequence, in chunks that are mapped into memory one at a time."""

    def __init__(self, store, where):
        self._store = store
        self._where = [where[frame] for frame in store.frames]
        self._name = self._frames = self._chunk = None

    def __len__(self):
        return len(self._where)

    def __getitem__(self, row):
        if self._where[row] != self._name:
            self._name = self._where[row]
            self._frames, self._chunk = self._store.chunk_of(self._name)
        return self._chunk[self._frames.index(self._store.frames[row])]
