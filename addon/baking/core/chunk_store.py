# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a bake on their way: chunks in a folder, each a file that is there only when it is whole.

Its name has the key of what is baked (a digest of all that it depends on) and the frames. So what was killed goes on
where it was, changed settings never mix with old chunks, and several processes may work on one folder without knowing
of each other.
"""

import contextlib
import itertools
import pathlib
import re

import numpy as np

from ...errors import DamagedCacheError, IncompleteCacheError
from ...scene.core import whole_files


class ChunkStore:
    """The chunks of one clip.

    folder    where they are
    key       digest of everything that the frames depend on
    frames    range of the numbers of all frames of the clip; with sub-frames the numbers of the samples
    """

    def __init__(self, folder, key, frames):
        self.folder = pathlib.Path(folder)
        self.key = key[:16]  # paths of Windows are short
        self.frames = frames

    def write(self, first, rows, problems):
        """Keeps the rows (f, n, 3) from frame `first` on, with f texts on what went wrong. @throws CacheError."""
        name = f"{self.key}_{first:+07d}_{first + len(rows) - 1:+07d}.npz"
        with whole_files.replacing(self.folder / name) as file:
            np.savez(file, rows=np.asarray(rows, "<f4"), problems=np.array(problems, str))

    def missing(self):
        """The frames that are in no chunk, ascending. Reads names alone."""
        where = self._where()
        return [frame for frame in self.frames if frame not in where]

    def merge(self, path, header):
        """Generator that puts the chunks together into the cache `path`, and yields the share that is done.

        Returns [text] of all frames, as write() was given them.

        @throws IncompleteCacheError, DamagedCacheError, after which the chunk is gone, CacheError.
        """
        where, missing = self._where(), self.missing()
        if missing:
            raise IncompleteCacheError(
                f"{len(missing)} of {len(self.frames)} frames are not baked yet, the first is {missing[0]}. Bake them "
                "first"
            )
        problems = []
        with whole_files.replacing(path) as file:
            file.write(header.packed())
            for (chunk, first), frames in itertools.groupby(self.frames, where.get):
                frames = [frame - first for frame in frames]
                rows, texts = _read(chunk, header.vertices)
                file.write(rows[frames[0] : frames[-1] + 1])
                problems += texts[frames[0] : frames[-1] + 1]
                yield len(problems) / len(self.frames)
        return problems

    def remove(self):
        """Takes all chunks away, whatever their key, and the folder if nothing else is in it."""
        with contextlib.suppress(OSError):
            for path in sorted(self.folder.glob("*")):
                if path.suffix in {".npz", ".pc2", ".json"} or ".tmp." in path.name:
                    path.unlink()
            self.folder.rmdir()

    def _where(self):
        """{frame: (path of the chunk that has it, its first frame)}."""
        where = {}
        for path in sorted(self.folder.glob(f"{self.key}_*.npz")):
            if match := re.fullmatch(r".*_([+-]\d+)_([+-]\d+)", path.stem):
                first, last = map(int, match.groups())
                for frame in range(max(first, self.frames[0]), min(last, self.frames[-1]) + 1):
                    where.setdefault(frame, (path, first))
        return where


def _read(path, vertices):
    """(rows, list of texts) of a chunk; the format has checksums. @throws DamagedCacheError."""
    with whole_files.telling(path), path.open("rb") as file:
        try:
            with np.load(file) as content:
                rows, texts = np.ascontiguousarray(content["rows"]), content["problems"].tolist()
            if rows.dtype == np.dtype("<f4") and rows.shape == (len(texts), vertices, 3):
                return rows, texts
        except Exception:  # damage shows in any of a dozen errors of NumPy's
            pass
    path.unlink(missing_ok=True)
    raise DamagedCacheError(
        f"{path} is not what was written (a damaged disk, or another program). It was taken out: bake again, which "
        "solves only its frames"
    )
