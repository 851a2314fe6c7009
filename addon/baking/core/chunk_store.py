# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a bake on their way: chunks in a folder, each a point cache with a marker beside it that is written last.

Beside them is how far a chunk is that somebody has stopped; whoever solves it next goes on from there.

A chunk counts only if its marker has the key of what is baked (a digest of all that it depends on), the frames and the
size. So what was killed goes on where it was, changed settings never mix with old chunks, and several processes may
work on one folder without knowing of each other.
"""

import contextlib
import hashlib
import json
import pathlib

import numpy as np

from ...errors import DamagedCacheError, IncompleteCacheError, MeanValueError
from ...scene.core import whole_files
from ...scene.core.checked_json import checked, checksum, read_checked_json, write_checked_json
from . import frame_ranges, point_cache

SCHEMA = 2

#: Of files that have how far a chunk is: a line of JSON, then the solver's own state.
BEGUN = ".begun"
MOST_HEAD_BYTES = 1 << 20


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
        path = self._path(frames)
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
        self.forget_begun(frames)

    def keep_begun(self, frames, state, solved):
        """Keeps how far `frames`, the chunk that is being solved, are, until they are written.

        state: (b,) uint8; solved: those of `frames` that need not be solved again. @throws CacheError.
        """
        head = {
            "schema": SCHEMA,
            "key": self.key,
            "frames": frame_ranges.spelled(frames),
            "vertices": self.vertices,
            "solved": frame_ranges.spelled(solved),
            "bytes": len(state),
            "sha256": hashlib.sha256(state).hexdigest(),
        }
        text = json.dumps({**head, "checksum": checksum(head)}).encode() + b"\n"
        with whole_files.replacing(self._begun_path(frames), len(text) + len(state)) as file:
            file.write(text)
            file.write(memoryview(state))

    def begun(self, frames):
        """(state, frames that need not be solved again) as kept for `frames`; (None, []) where there is nothing."""
        path = self._begun_path(frames)
        head = self._read_head(path)
        with contextlib.suppress(OSError, MemoryError):
            if head is not None and head["frames"] == frame_ranges.spelled(frames):
                with path.open("rb") as file:
                    file.readline(MOST_HEAD_BYTES)
                    state = np.frombuffer(file.read(), np.uint8)
                if hashlib.sha256(state).hexdigest() == head["sha256"]:
                    return state, frame_ranges.parse(head["solved"])
        return None, []

    def forget_begun(self, frames):
        with contextlib.suppress(OSError):
            self._begun_path(frames).unlink(missing_ok=True)

    def kept(self, chunks):
        """Frames that need not be solved again, ascending: those that are written, and those of `chunks` that are on
        their way."""
        found = set(self._where())
        for frames in chunks:
            head = self._read_head(self._begun_path(frames))
            if head is not None and head["frames"] == frame_ranges.spelled(frames):
                found.update(frame_ranges.parse(head["solved"]))
        return [frame for frame in self.frames if frame in found]

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
                own = frame_ranges.parse(marker["frames"])
                begin = own.index(frames[0])
                self._copy_checked(name, marker, (begin, begin + len(frames)), file)
                done += len(frames)
                yield done
        return reports

    def rows(self):
        """Row k of the clip by `rows()[k]`, (n, 3) float32; rows stay on the disk. @throws IncompleteCacheError."""
        return _Rows(self, self._require_all())

    def reports(self):
        """{name: values of all frames} of the reports. @throws IncompleteCacheError."""
        where = self._require_all()
        reports = {}
        for name, frames in self._stretches(where):
            marker = self._require_marker(name)
            first = frame_ranges.parse(marker["frames"]).index(frames[0])
            for what, values in marker["report"].items():
                reports.setdefault(what, []).extend(values[first : first + len(frames)])
        return reports

    def remove(self):
        """Takes all chunks away, whatever their key, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in sorted(self.folder.glob("*")):
                if path.suffix in {".pc2", ".json", BEGUN} or ".tmp." in path.name:
                    path.unlink()
            self.folder.rmdir()

    def _copy_checked(self, name, marker, rows, file):
        """Appends rows [begin, end) of a chunk, all of which is checked. @throws DamagedCacheError."""
        path = self.folder / f"{name}.pc2"
        state = hashlib.sha256()
        row = 0
        with whole_files.telling(path):
            header = point_cache.read_header(path)
            state.update(header.packed())
            for portion in point_cache.portions(path):
                state.update(memoryview(portion).cast("B"))
                wanted = portion[max(0, rows[0] - row) : max(0, rows[1] - row)]
                row += len(portion)
                if len(wanted):
                    file.write(memoryview(np.ascontiguousarray(wanted)).cast("B"))
        if state.hexdigest() != marker["sha256"]:
            self._discard(name)
            raise DamagedCacheError(
                f"Frames {marker['frames']} in {path} are not what was written (a damaged disk, or another program). "
                "They were taken out: bake again, which solves only them"
            )

    def _discard(self, name):
        for suffix in (".json", ".pc2"):
            (self.folder / f"{name}{suffix}").unlink(missing_ok=True)

    def _require_all(self):
        """As _where(). @throws IncompleteCacheError."""
        where = self._where()
        missing = [frame for frame in self.frames if frame not in where]
        if missing:
            raise IncompleteCacheError(
                f"{len(missing):,} of {len(self.frames):,} frames are not baked yet: {_few(missing)}. Bake them first"
            )
        return where

    def _where(self):
        """{frame: name of the chunk that has it}."""
        wanted = set(self.frames)
        where = {}
        for path in sorted(self.folder.glob("*.json")):
            marker = self._read_marker(path)  # one that is written at this moment is not there yet
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
        marker = self._read_marker(self.folder / f"{name}.json")
        if marker is None:
            raise IncompleteCacheError(f"A part of the bake, {name}, is gone from {self.folder} meanwhile. Bake again")
        return marker

    def _read_marker(self, path):
        marker = read_checked_json(path)
        return marker if marker is not None and marker.get("schema") == SCHEMA else None

    def _read_head(self, path):
        """Of a chunk on its way; None if it is of something else, or damaged."""
        try:
            with path.open("rb") as file:
                text = file.readline(MOST_HEAD_BYTES)
                head = checked(json.loads(text))
                size = len(text) + head["bytes"] if head is not None else -1
                is_whole = path.stat().st_size == size
                if head is not None:
                    frame_ranges.parse(head["solved"])
        except (OSError, ValueError, KeyError, TypeError, RecursionError, MemoryError, MeanValueError):
            return None
        return head if is_whole and (head["schema"], head["key"], head["vertices"]) == self._own() else None

    def _own(self):
        return SCHEMA, self.key, self.vertices

    def _begun_path(self, frames):
        return self._path(frames).with_suffix(BEGUN)

    def _path(self, frames):
        """By the frames alone, so that whoever bakes the same frames writes the same file."""
        runs = frame_ranges.runs(frames)
        return self.folder / (".".join(f"{first:+07d}_{last:+07d}" for first, last in runs) + ".pc2")


class _Rows:
    """The rows of a ChunkStore as a sequence, in chunks that are mapped into memory one at a time."""

    def __init__(self, store, where):
        self._store = store
        self._where = [where[frame] for frame in store.frames]
        self._name = self._mapped = self._numbers = None

    def __len__(self):
        return len(self._where)

    def __getitem__(self, row):
        name = self._where[row]
        if name != self._name:
            marker = self._store._require_marker(name)
            self._numbers = {frame: k for k, frame in enumerate(frame_ranges.parse(marker["frames"]))}
            path = self._store.folder / f"{name}.pc2"
            shape = (len(self._numbers), self._store.vertices, 3)
            with whole_files.telling(path):
                self._mapped = np.memmap(path, "<f4", mode="r", offset=32, shape=shape)
            self._name = name
        return self._mapped[self._numbers[self._store.frames[row]]]


def _few(frames):
    text = frame_ranges.spelled(frames)
    return text if len(text) <= 60 else text[:60].rsplit(",", 1)[0] + ", ..."
