# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of a bake, chunk by chunk: what was done before is kept, what is done stays, whatever happens."""

import pathlib
import time

import numpy as np

from ...errors import CancelledError, SceneError, SolverError
from ...scene.core.checked_json import read_json, write_json
from ...solver import native_loader
from ...wording import counted
from ..core import bake_report, bake_times, frame_ranges, key_reduction, point_cache
from ..core.bake_report import BakeReport
from ..core.chunk_store import ChunkStore
from . import solving
from .solving import PausedRows

#: Of the report beside a cache.
SCHEMA = 1

#: Of frames that are kept, as a message tells them.
MOST_RANGES = 4

#: Of a chunk on its way, for each vertex: of a frame, and of a run at work. One that has more bytes is not waited for
#: when Blender quits.
BYTES_OF_FRAME, BYTES_OF_RUN, MOST_LEFT = 12, 400, 2**27


class Baking:
    """Steps (see workers.job) that solve a plan and write what becomes of it; Blender is not touched.

    plan      the BakePlan, or MixPlan
    posing    workers.posing.Posing, or workers.mixing.Mixing, of the same mesh, which binds
    path      of the point cache; for shape keys only where the chunks and the report are
    part      (begin, end) of the rows to bake again in the cache at `path`, or None for all
    """

    def __init__(self, plan, posing, path, part=None):
        self.plan = plan
        self.path = pathlib.Path(path)
        self._posing = posing
        self._part = part or (0, len(plan.times))
        numbers = list(plan.numbers)[slice(*self._part)]
        folder = self.path.with_name(f"{self.path.name.removesuffix('.pc2')}.chunks")
        self.store = ChunkStore(folder, plan.key, numbers, plan.vertices)
        self.done = 0
        self.total = len(numbers)
        self.begun_at = None
        self._doing = 0  # rows that are being solved
        self._execution = self._progress_before = None

    def work(self, execution):
        """Steps: binds if need be, and solves all chunks that are missing. @throws MeanValueError."""
        self._execution = execution
        for begin, end, numbers in self._chunks():
            if not self.store.has(numbers):
                if self._is_pausing:
                    raise CancelledError(self.stopped())
                yield from self._solve(begin, end, numbers, execution)
            self.done += end - begin

    def _chunks(self):
        """[(begin, end, frame numbers)] of what is baked."""
        first, last = self._part
        numbers = list(self.plan.numbers)
        found = [(max(begin, first), min(end, last)) for begin, end in self.plan.chunks()]
        return [(begin, end, numbers[begin:end]) for begin, end in found if begin < end]

    def _solve(self, begin, end, numbers, execution):
        try:
            if self._posing.binding is None:
                yield from self._posing.work(execution)
            state, begun = self.store.begun(numbers)
            self.begun_at = self.begun_at or (time.monotonic(), self.done + len(begun))
            self._doing = end - begin
            self._progress_before = execution.progress if execution is not None else None  # the last chunk's
            solved = yield from self._solve_or_go_on(begin, end, numbers, execution, state)
        except CancelledError as error:
            raise CancelledError(self.stopped()) from error
        finally:
            self._doing = 0
        if isinstance(solved, PausedRows):
            done = [number for number, is_solved in zip(numbers, solved.solved, strict=True) if is_solved]
            if done:
                self.store.keep_begun(numbers, solved.state, done)
            raise CancelledError(self.stopped())
        self.store.write(numbers, solved.vertices, solved.report)

    def _solve_or_go_on(self, begin, end, numbers, execution, state):
        if state is not None:
            try:
                return (yield from self.plan.solve_rows(self._posing.binding, begin, end, execution, 0, state))
            except SolverError as error:
                if not isinstance(error.__cause__, native_loader.module().InvalidInput):
                    raise
                self.store.forget_begun(numbers)  # of another build of the solver
                self.begun_at = (time.monotonic(), self.done)
        return (yield from self.plan.solve_rows(self._posing.binding, begin, end, execution))

    def stop(self):
        """Asks the work to stop where it can be gone on with; asked again, at once. @pre work() has begun."""
        if self._doing and not self._is_pausing:
            self._execution.pause()
        else:
            self._execution.cancel()

    def stop_before_leaving(self):
        """As stop(), if what has to be written then is soon written. Returns whether it stops that way."""
        runs = -(-self._doing // solving.RUN_FRAMES)
        if not 0 < self.plan.vertices * (BYTES_OF_FRAME * self._doing + BYTES_OF_RUN * runs) <= MOST_LEFT:
            return False
        if not self._is_pausing:
            self._execution.pause()
        return True

    @property
    def _is_pausing(self):
        return self._execution is not None and self._execution.pausing

    def stopped(self):
        """What is said when it was stopped."""
        kept = self.store.kept([numbers for _, _, numbers in self._chunks()])
        which = f" ({self._named(kept)})" if kept else ""
        told = f"{counted(len(kept), 'frame')} of {self.total:,} {'is' if len(kept) == 1 else 'are'} kept{which}"
        return f"Stopped. {told}: Bake again goes on from there"

    def _named(self, numbers):
        """As "1 to 120, 145 to 169"; after MOST_RANGES only how many more there are."""
        first = self.plan.numbers[0]
        times = self.plan.times
        found = [
            " to ".join(dict.fromkeys(bake_times.named(times[number - first]) for number in ends))
            for ends in frame_ranges.runs(numbers)
        ]
        more = len(found) - MOST_RANGES
        return ", ".join(found[:MOST_RANGES] + ([f"and {counted(more, 'more range')}"] if more > 0 else []))

    @property
    def share(self):
        """0 to 1."""
        return self.frames_done / max(1, self.total)

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
        if self.begun_at is None or self.frames_done <= self.begun_at[1]:
            return None
        speed = (time.monotonic() - self.begun_at[0]) / (self.frames_done - self.begun_at[1])
        return speed * (self.total - self.frames_done)

    def write_cache(self, about):
        """Generator of rows that are written: puts the cache together and its report beside it. Returns the BakeReport.

        about: {name: text} of what was baked. @throws CacheError; the old cache is then as it was.
        """
        if self._part != (0, len(self.plan.times)):
            return (yield from self._rewrite_part(about))
        columns = yield from self.store.merge(self.path, self.plan.header)
        report = BakeReport.of(self.plan.times, columns)
        self.write_report(report, {**about, "key": self.plan.key, "bytes": self.plan.header.bytes})
        self.store.remove()
        return report

    def _rewrite_part(self, about):
        require_cache(self.path, self.plan)
        begin, _end = self._part
        rows = self.store.rows()
        point_cache.write_again(self.path, begin, (rows[row][None] for row in range(len(rows))))
        yield len(rows)
        report = BakeReport.of(self.plan.times[slice(*self._part)], self.store.reports())
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
        return kept, shapes, BakeReport.of(self.plan.times, self.store.reports())

    def write_report(self, report, about):
        """Beside the cache. @throws CacheError."""
        write_report(self.path, report, about)


def write_report(path, report, about):
    """Beside the cache `path`: a BakeReport and what `about` says, as JSON. @throws CacheError."""
    write_json(report_path(path), {"schema": SCHEMA, **about, **report.content()})


def report_path(path):
    """Of the report that is written beside the cache `path`; it tells whose bake that is, too."""
    path = pathlib.Path(path)
    return path.with_name(f"{path.name}.json")


def is_current(path, plan):
    """Whether the cache at `path` holds what `plan` would give."""
    marker = read_json(report_path(path))
    try:
        size = pathlib.Path(path).stat().st_size
    except OSError:
        return False
    return marker is not None and marker.get("key") == plan.key and size == plan.header.bytes


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
