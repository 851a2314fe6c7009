# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of a bake, chunk by chunk: what was done before is kept, what is done stays, whatever happens."""

import time

import bpy
import numpy as np

from ...errors import CancelledError
from ...scene import baked, frames
from ...scene.baked import TO_KEYS
from ...wording import counted
from ..core import bake_times, point_cache
from . import handle_source, preparing
from .clips import BakePlan, RowClip
from .taken_along import TakenAlong


class Baking:
    """One object with its options (attributes as properties.py), in place of a Posing for widgets/background.py.

    plan, begun     None until sample() went through
    kept, shapes    for shape keys: which rows, and what they are
    is_done         whether the point cache is there already
    """

    def __init__(self, obj, scene, options):
        """@throws SceneError if the options do not fit the object; nothing was changed then."""
        self.options = options
        self.to_keys = options.target == TO_KEYS
        self.scene_name = scene.name
        self.times = preparing.times_of(scene, obj, options)
        self.shown_path, self.path = preparing.paths(obj, options)
        preparing.require_fit(obj, self.times, options, self.path)
        self._kind = baked.source(obj) or handle_source
        self._along = TakenAlong(obj, self.times, options) if self._kind is handle_source else None
        self.posing = self._kind.bind(obj)
        self.require_unchanged = self.posing.require_unchanged
        self.plan = self.begun = self.kept = self.shapes = self._execution = None
        self.is_done = False
        self._doing = 0  # rows of the chunk that is being solved
        self._begun_at = None  # (seconds, rows that were done then)

    def sample(self, find):
        """Generator of the share that is done. find() returns the object. @throws SceneError."""
        scene, bind_input = bpy.data.scenes[self.scene_name], self.posing.bind_input
        visit = frames.visit(scene, self.times, lambda: self._kind.row(find(), bind_input))
        rows = np.array((yield from visit))
        if self._kind is handle_source:
            clip = handle_source.clip(find(), bind_input, rows, self.times)
            self._shares = rows[:, 0, 4]
        else:
            clip = RowClip(self._kind, bind_input, rows)
        self.plan = BakePlan(clip, self.times, 1.0 / self.options.samples)
        if not self.to_keys:
            self.is_done = point_cache.is_current(self.path, self.plan.key, self.plan.header)
        self.begun = point_cache.Begun(self.path, self.plan.key, self.plan.header)

    def work(self, execution):
        """Steps (see solver/job.py) that bind if need be and solve what is missing. @throws MeanValueError."""
        if self.is_done:
            return
        self._execution = execution
        for begin, end in self.plan.chunks():
            if end > len(self.begun.problems):
                try:
                    yield from self._solve(begin, end)
                except CancelledError as error:
                    raise CancelledError(self.stopped()) from error

    def _solve(self, begin, end):
        if self.posing.binding is None:
            yield from self.posing.work(self._execution)
        self._begun_at = self._begun_at or (time.monotonic(), begin)
        self._doing = end - begin
        rows, problems = yield from self.plan.clip.solve_rows(self.posing.binding, begin, end, self._execution)
        self._doing = 0
        self.begun.write(begin, rows, problems)

    def stopped(self):
        """What is kept, for whoever has stopped it; None before anything could be."""
        if self.begun is None:
            return None
        kept = counted(len(self.begun.problems), "frame")
        return f"Stopped. {kept} of {len(self.times):,} kept: Bake again goes on from there"

    def progress(self):
        """(rows that are done, of how many, seconds that are left or None), or None as long as nothing is solved."""
        if self._begun_at is None:
            return None
        total = len(self.times)
        done = len(self.begun.problems) + int(self._execution.progress % 1.0 * self._doing)  # 1: of the chunk before
        seconds, before = time.monotonic() - self._begun_at[0], self._begun_at[1]
        return done, total, seconds / (done - before) * (total - done) if done > before else None

    def write(self, obj):
        """Has the cache be whole, or chooses the shape keys: generator of the share done. @throws CacheError."""
        if not self.to_keys:
            if not self.is_done:
                self.begun.become_whole()
            preparing.write_marker(self.path, obj, self.plan.key)
            if self._along is not None:
                yield from self._along.write(obj, point_cache.mapped(self.path), self.plan)
            return
        rows, rest = point_cache.mapped(self.begun.path), self.posing.bind_input.rest
        if self._kind is handle_source and self._shares.min() < 1.0:  # kept poses, which play on, show what is missing
            rows = [rest + np.float32(share) * (row - rest) for row, share in zip(rows, self._shares, strict=True)]
        self.kept = list(range(len(rows)))
        tolerance = self.options.tolerance_share / 100.0 * self.posing.bind_input.diagonal
        if tolerance > 0.0:
            self.kept = yield from bake_times.reduced(rows, self.times, tolerance)
        self.shapes = [np.array(rows[row]) for row in self.kept]
        if self._along is not None:
            yield from self._along.choose(obj, self.shapes)

    def play_along(self, obj):
        """What goes along plays its bake, too. Returns notes."""
        times = self.times[self.kept] if self.to_keys else None
        return self._along.play(obj, self.plan, times) if self._along is not None else []
