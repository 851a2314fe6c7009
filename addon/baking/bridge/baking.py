# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of a bake, chunk by chunk: what was done before is kept, what is done stays, whatever happens."""

import time
import types

import bpy
import numpy as np

from ...compat import session_key
from ...errors import CancelledError, SceneError, require_none
from ...scene import along, baked, frames, shape_keys, worn
from ...scene.baked import TO_BONES, TO_CACHE, TO_KEYS
from ...scene.core import whole_files
from ...solver.core.fingerprint import digest
from ...wording import counted
from ..core import bake_times, point_cache
from . import bones, handle_source, playing, preparing
from .clips import BakePlan, RowClip


class Baking:
    """One object with its options (attributes as properties.py), in place of a Posing for widgets/background.py.

    plan, begun     None until sample() went through
    is_done         whether the point cache is there already
    _paths          {session key: (as the modifier shows it, in full)} of the mesh and of what goes along
    _made           {session key: [n x 3 float32], or [] for a point cache} of what plays the bake
    """

    def __init__(self, obj, scene, options):
        """@throws SceneError if the options do not fit the object; nothing was changed then."""
        self.options = options
        self.scene_name = scene.name
        self.times = preparing.times_of(scene, obj, options)
        self._kind = None if options.target == TO_BONES and bones.is_seen(obj) else baked.source(obj) or handle_source
        self._paths, self._made = {}, {}
        self._find_room(along.group(obj) if self._kind is handle_source else [obj])
        self.shown_path, self.path = self._paths[session_key(obj)]
        self.posing = self._kind and self._kind.bind(obj)
        self.require_unchanged = self.posing.require_unchanged if self.posing else lambda obj: None
        self.plan = self.begun = self._kept = self._bones = self._execution = None
        self.is_done = False
        self._doing = 0  # rows of the chunk that is being solved
        self._begun_at = None  # (seconds, rows that were done then)

    def _find_room(self, objects):
        homes, options = {}, self.options
        for each in objects:
            stem = options.path.strip().removesuffix(".pc2")
            path = options.path if each == objects[0] else stem and f"{stem}_{preparing.file_name_of(each)}.pc2"
            own = types.SimpleNamespace(**{**vars(options), "path": path})
            shown, path = self._paths[session_key(each)] = preparing.paths(each, own)
            first = homes.setdefault(str(path).casefold(), each)
            if shown and first != each:
                raise SceneError(f"'{first.name}' and '{each.name}' would be baked to one file. Rename one of them")
            whole_files.require_place(path)
            doubts = preparing.doubts(each, self.times, own, path)
            if doubts and not options.confirm:
                raise SceneError(". ".join([*doubts, "If that is what you want, bake with confirm=True"]))
            require_none(preparing.target_problem(each, own))

    def sample(self, find):
        """Generator of the share that is done. find() returns the object. @throws SceneError."""
        if self._kind is None:
            return
        scene, bind_input = bpy.data.scenes[self.scene_name], self.posing.bind_input
        rows = np.array((yield from frames.visit(scene, self.times, lambda: self._kind.row(find(), bind_input))))
        clip = RowClip(self._kind, bind_input, rows)
        if self._kind is handle_source:
            clip = handle_source.clip(find(), bind_input, rows, self.times, target=self.options.target)
        self.plan = BakePlan(clip, self.times, 1.0 / self.options.samples)
        if self.options.target == TO_CACHE:
            self.is_done = point_cache.is_current(self.path, self.plan.key, self.plan.header)
        self.begun = point_cache.Begun(self.path, self.plan.key, self.plan.header)

    def work(self, execution):
        """Steps (see solver/job.py) that bind if need be and solve what is missing. @throws MeanValueError."""
        if self.is_done or self._kind is None:
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
        """Has the cache be whole, or finds keys or bones: generator of the share done. @throws MeanValueError."""
        if self.options.target == TO_CACHE:
            if not self.is_done:
                self.begun.become_whole()
            preparing.write_marker(self.path, obj, self.plan.key)
            self._made[session_key(obj)] = []
            yield from self._write_along(obj, point_cache.mapped(self.path))
            return
        still = [shape_keys.rest_positions(obj.data)] * len(self.times)
        shapes = still if self._kind is None else (yield from self._shapes())
        for number, shape in enumerate(shapes):
            for follower, others in self._followers(obj):
                for other, found in zip(others, follower.follow(shape), strict=True):
                    self._made.setdefault(session_key(other), []).append(found)
            yield number / len(shapes)
        self._made = {key: made for key, made in self._made.items() if len(made) == len(shapes)}
        self._made[session_key(obj)] = shapes
        if self.options.target == TO_BONES:
            made = [(each, self._made[session_key(each)]) for each in self._parts(obj)]
            self._bones = yield from bones.fit(*zip(*made, strict=True), self.times, self._kind is None, self.options)

    def _followers(self, obj):  # of what it began with: others may go along since
        return along.followers(obj, [each for each in worn.taken(obj) if session_key(each[1]) in self._paths])

    def _parts(self, obj):
        return [each for each in along.group(obj) if session_key(each) in self._made]

    def _shapes(self):
        rows = point_cache.mapped(self.begun.path)
        self._kept = list(range(len(rows)))
        tolerance = self.options.tolerance_share / 100.0 * self.posing.bind_input.diagonal
        if tolerance > 0.0 and self.options.target == TO_KEYS:
            self._kept = yield from bake_times.reduced(rows, self.times, tolerance)
        return [np.array(rows[row]) for row in self._kept]

    def _write_along(self, obj, rows):
        """The point caches of what goes along, of those of the mesh: generator of the share done."""
        plan = self.plan
        for follower, others in self._followers(obj):
            key = digest(plan.key, *follower.key, *follower.places)
            homes = [(self._paths[session_key(one)][1], key, plan.header_of(len(one.data.vertices))) for one in others]
            self._made.update({session_key(each): [] for each in others})
            if all(point_cache.is_current(*home) for home in homes):
                continue
            caches = [point_cache.Begun(*home) for home in homes]
            for begin, end in plan.chunks():
                shapes = []
                for row in rows[begin:end]:
                    shapes.append(follower.follow(np.array(row)))
                    yield (begin + len(shapes)) / len(rows)
                for cache, found in zip(caches, zip(*shapes, strict=True), strict=True):
                    cache.write(begin, np.array(found), [""] * (end - begin))
            for cache, other, home in zip(caches, others, homes, strict=True):
                cache.become_whole()
                preparing.write_marker(home[0], other, key)

    def play(self, obj):
        """What was made plays, in what goes along too. Returns (what it is, how near it is or "", notes), in words."""
        parts, notes, made = self._parts(obj), along.problems(obj), f"'{self.shown_path}'"
        for each in parts:
            playing.take_back(each)
        if self.options.target == TO_BONES:
            made, near, more = bones.play(parts, *self._bones, self.times, self._kind is None, self.options)
            return made, near, [*notes, *more]
        for each in parts:
            key = session_key(each)
            if self.options.target == TO_KEYS:
                times = self.times[self._kept]
                notes += playing.play_keys(each, times, self._made[key])
                made = counted(len(times), "shape key")
            else:
                header = self.plan.header_of(len(each.data.vertices))
                playing.play_cache(each, self._paths[key][0], header)
        return made, "", notes
