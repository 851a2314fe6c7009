# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of a bake, chunk by chunk: what was done before is kept, what is done stays, whatever happens."""

import pathlib
import time

import numpy as np

from ...errors import CancelledError, SceneError
from ...scene.core.checked_json import read_json, write_json
from ...wording import counted
from ..core import bake_report, key_reduction, point_cache
from ..core.bake_report import BakeReport
from ..core.chunk_store import ChunkStore

#: Of the report beside a cache.
SCHEMA = 1


class Baking:
    """Steps (see solver/job.py) that solve a plan and write what becomes of it; Blender is not touched.

    plan      the BakePlan
    posing    what binds, of the same mesh
    path      of the point cache; for shape keys only where the chunks and the report are
    part      (begin, end) of the rows to bake again in the cache at `path`, or None for all
    """

    def __init__(self, plan, posing, path, part=None):
        self.plan = plan
        self.path = pathlib.Path(path)
        self._posing = posing
        self._is_part = part is not None
        self._part = part or (0, len(plan.times))
        numbers = list(plan.numbers)[slice(*self._part)]
        folder = self.path.with_name(f"{self.path.name.removesuffix('.pc2')}.chunks")
        self.store = ChunkStore(folder, plan.key, numbers, plan.vertices)
        self.done = 0
        self.total = len(numbers)
        self._begun_at = None  # (seconds, rows that were done then)
        self._doing = 0  # rows that are being solved
        self._execution = self._progress_before = None

    def work(self, execution):
        """Steps: binds if need be, and solves all chunks that are missing. @throws MeanValueError."""
        self._execution = execution
        for begin, end, numbers in self._chunks():
            if not self.store.has(numbers):
                try:
                    yield from self._solve(begin, end, numbers)
                except CancelledError as error:
                    raise CancelledError(self.stopped()) from error
                finally:
                    self._doing = 0
            self.done += end - begin

    def _chunks(self):
        """[(begin, end, frame numbers)] of what is baked."""
        first, last = self._part
        numbers = list(self.plan.numbers)
        found = [(max(begin, first), min(end, last)) for begin, end in self.plan.chunks()]
        return [(begin, end, numbers[begin:end]) for begin, end in found if begin < end]

    def _solve(self, begin, end, numbers):
        if self._posing.binding is None:
            yield from self._posing.work(self._execution)
        self._begun_at = self._begun_at or (time.monotonic(), self.done)
        self._progress_before = self._execution.progress if self._execution is not None else None  # the last chunk's
        self._doing = end - begin
        rows, report = yield from self.plan.clip.solve_rows(self._posing.binding, begin, end, self._execution)
        self.store.write(numbers, rows, report)

    def stopped(self):
        """What is kept, for whoever has stopped it."""
        kept = self.total - len(self.store.missing())
        if kept == 0:
            return "Stopped, before the first frames were whole"
        verb = "is" if kept == 1 else "are"
        return f"Stopped. {counted(kept, 'frame')} of {self.total:,} {verb} kept: Bake again goes on from there"

    @property
    def is_solving(self):
        return self._begun_at is not None

    @property
    def frames_done(self):
        """With those of the chunk that is being solved."""
        share = self._execution.progress if self._execution is not None else 0.0
        if share == self._progress_before:  # the solver has not begun with this chunk
            share = 0.0
        return min(self.total, self.done + int(share * self._doing))

    @property
    def seconds_left(self):
        """By the frames that were solved so far, None as long as nothing is known."""
        if self._begun_at is None or self.frames_done <= self._begun_at[1]:
            return None
        speed = (time.monotonic() - self._begun_at[0]) / (self.frames_done - self._begun_at[1])
        return speed * (self.total - self.frames_done)

    def write_cache(self, about):
        """Generator of rows that are written: puts the cache together and its report beside it. Returns the BakeReport.

        about: {name: text} of what was baked. @throws CacheError; the old cache is then as it was.
        """
        if self._is_part:
            return (yield from self._rewrite_part(about))
        columns = yield from self.store.merge(self.path, self.plan.header)
        report = BakeReport(self.plan.times, columns)
        write_report(self.path, report, {**about, "key": self.plan.key})
        self.store.remove()
        return report

    def _rewrite_part(self, about):
        require_cache(self.path, self.plan)
        rows = self.store.rows()
        point_cache.write_again(self.path, self._part[0], (rows[row][None] for row in range(len(rows))))
        yield len(rows)
        report = BakeReport(self.plan.times[slice(*self._part)], self.store.reports())
        former = read_json(report_path(self.path)) or {}
        content = {
            **former,
            **about,
            "key": f"{former.get('key', '')}, in part {self.plan.key}",
            "frames": bake_report.with_frames(former.get("frames"), report.content()["frames"]),
        }
        write_json(report_path(self.path), content)
        self.store.remove()
        return report

    def choose_keys(self, tolerance, key_step):
        """Generator of rows that are looked at. Returns (rows to keep, their shapes, BakeReport).

        tolerance: a distance, or None for every `key_step`-th row.
        """
        rows = self.store.rows()
        if tolerance is None:
            kept = key_reduction.every(len(rows), key_step)
        else:
            kept = yield from key_reduction.reduced(rows, self.plan.times, tolerance)
        shapes = []
        for row in kept:
            shapes.append(np.array(rows[row]))
            yield row
        return kept, shapes, BakeReport(self.plan.times, self.store.reports())


def write_report(path, report, about):
    """Beside the cache `path`: a BakeReport and what `about` says, as JSON. @throws CacheError."""
    write_json(report_path(path), {"schema": SCHEMA, **about, **report.content()})


def report_path(path):
    """Of the report that is written beside the cache `path`; it tells whose bake that is, too."""
    path = pathlib.Path(path)
    return path.with_name(f"{path.name}.json")


def is_current(path, key, header):
    """Whether the cache at `path` is what was baked with this key."""
    marker = read_json(report_path(path))
    try:
        size = pathlib.Path(path).stat().st_size
    except OSError:
        return False
    return marker is not None and marker.get("key") == key and size == header.bytes


def require_cache(path, plan):
    """The cache of which a part is baked again has the same samples. @throws SceneError, CacheError."""
    if not pathlib.Path(path).exists():
        raise SceneError(f"There is no point cache at '{path}' to bake a part of. Turn Part Only off")
    found = point_cache.read_header(path)
    if found != plan.header:
        raise SceneError(
            f"The point cache has {found.samples:,} samples of {found.vertices:,} vertices from frame {found.start:g}, "
            f"the bake would have {plan.header.samples:,} of {plan.vertices:,} from {plan.header.start:g}. Set the "
            "range as it was, or turn Part Only off"
        )
