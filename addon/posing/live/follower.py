# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing of one object by its handles."""

import bpy
import numpy as np

from ... import wording
from ...live import roll
from ...live.following import Following
from ...scene import actions, along, key_marks, mesh_arrays, rig_space, shape_keys, views
from ...solver import session
from ...solver.core import result
from ..bridge import controls, scene_input, targets
from .live_targets import EarlyPoses, LiveTargets, SnapWatch

#: Shapes closer than this, as a share of the bounding-box diagonal, are the same for the eye and for the solver (its
#: own tolerance is 1e-4): a shape that was reopened or undone is not written again.
SAME_SHAPE = 2e-4

#: Targets closer than this are the same: noise of float32 matrices.
SAME_TARGETS = 1e-6


def turned(obj):
    """Live was turned on or off."""
    follower = roll.follower_of(obj)
    if not obj.meanvalue.live and isinstance(follower, Follower):
        follower.take_back(obj)
    if obj.meanvalue.live:
        roll.turned_on(obj, next(kind for kind in roll.kinds_on(obj) if issubclass(kind, Follower)))
    obj.update_tag(refresh={'OBJECT'})  # without, the mesh too is told of as edited


class Follower(Following):
    """The newest targets win. The last word is the better of where it is and rest; at another frame, of rest alone."""

    READS = scene_input.READING
    FOLLOWS = "controls"
    AND_EXPORTS = ", and export without the controls"
    LABEL = "Live"

    _drag = session.Drag()  # what the last solve was of

    _cached_binding = staticmethod(lambda bind_input: session.cache.get(bind_input.fingerprint))
    _make_key = staticmethod(shape_keys.ensure_result_key)

    @staticmethod
    def asks_for(obj):
        return obj.meanvalue.live and not any(kind.asks_for(obj) for kind in Follower.__subclasses__())

    @staticmethod
    def turn(obj, is_on):
        obj.meanvalue.live = is_on

    @staticmethod
    def why_hidden(obj):
        return shape_keys.why_result_is_hidden(obj) or controls.stillness(obj, targets.moved_handles(obj))

    @staticmethod
    def is_animated(obj):
        moving = {handle.control for handle in targets.moved_handles(obj)}.difference(rig_space.armatures(obj))
        return any(map(actions.is_animated, moving))  # renders follow the armatures

    def is_settled(self, obj):
        return super().is_settled(obj) and (self.problem is not None or self._drag.drafted is None)

    def take_back(self, obj):
        """A draft gives way to the last answer, where none is to follow."""
        if self._drag.drafted is None or not self._has_key(obj):
            return
        if len(self._drag.answer) == len(obj.data.vertices):
            self._write(obj, self._drag.answer)
        self._drag.drafted = None

    def stop(self):
        super().stop()
        self._end_early()

    def notes(self):
        yield from targets.held_back_notes(self._wanted.held_back)
        yield from self._binding.notes
        yield from result.torn_notes(self._input, self._wanted.positions)
        if self._drag.snaps is not None and self._drag.snaps.found is not None:
            yield f"the pose snaps at frame {self._drag.snaps.found}: key one in between"

    def _begin_anew(self):
        super()._begin_anew()
        self._targets = LiveTargets()
        # The mesh does not hold what a draft stands in for.
        self._drag = session.Drag(answer=self._drag.answer, drafted=self._drag.drafted)

    # Posing

    def _read(self, obj, is_quiet, compares):
        is_posed = self._wanted is not None or self._drag.answer is not None
        try:
            super()._read(obj, is_quiet, compares)
        finally:
            is_left = all(handle.follows == 'REST' for handle in targets.enabled_handles(obj))
            if is_left and is_posed and self._has_key(obj):
                self._held(obj)
                self._drag, self._wanted = session.Drag(), None
                self._write(obj, shape_keys.rest_positions(obj.data))  # handles that are gone pose nothing

    def _read_targets(self, obj):
        if self._shown is None:  # what was edited must not be bound unasked
            scene_input.require_fits(obj.meanvalue.bound, self._input.fingerprint)
        return self._targets.gather(obj, self._input, self._wanted)

    def _is_same_target(self, first, second):
        return first.is_near(second, SAME_TARGETS * self._input.diagonal)

    def _has_chores(self, obj):
        return self._targets.is_behind(obj) or along.is_behind(obj, self._model(obj).written)

    def _do_chores(self, obj):
        self._targets.catch_up(obj, self._input)
        key_marks.give_way(obj)
        along.pose(obj, self._model(obj).written)

    def _write(self, obj, shape):
        is_made = not self._has_key(obj)
        joined = None if is_made or self._model(obj).written is not None else shape_keys.keep_joined(obj, shape)
        if joined:
            views.say(wording.sentence(joined))
        super()._write(obj, shape)
        along.pose(obj, shape, makes_keys=is_made)

    def _bind_work(self, obj):
        bind_input = self._input
        known = session.cache.relative(bind_input.fingerprint.family)
        triangles = mesh_arrays.triangles(obj.data, bind_input.rest, bind_input.face_corners) if known is None else None

        def collect(owner, binding):
            self._binding = binding
            session.remember(bind_input, binding)
            scene_input.note_binding(owner.meanvalue.bound, bind_input.fingerprint)

        return lambda run: session.bind_steps(bind_input, triangles, run, known=known, early=True), collect

    def _held(self, obj):
        """n x 3 float32: what the result holds. What the artist has made of it becomes a key of its own."""
        if self._model(obj).written is not None:
            return self._model(obj).written
        held = shape_keys.held(obj, obj.meanvalue.result_key)
        held, note = shape_keys.keep_edit(obj, held, self._model(obj).overwritten)
        if note:
            views.say(wording.sentence(note))
        return held

    def _solve_work(self, obj, settles):
        binding, bind_input, wanted = self._binding, self._input, self._wanted
        is_first, shown, drag = self._model(obj).written is None, self._held(obj), self._drag
        if is_first or drag.binding is not binding:
            self._end_early()
            answer, drafted = self._before_draft(shown)
            drag = self._drag = session.begin_drag(binding, bind_input, answer)
            drag.drafted, drag.snaps, drag.frame = drafted, SnapWatch(), bpy.context.scene.frame_current_final
        if settles and drag.frame != bpy.context.scene.frame_current_final:
            drag.frame = bpy.context.scene.frame_current_final
            drag.native = session.begin_drag(binding, bind_input).native

        def collect(owner, answer):
            if settles and self._wanted is not wanted:
                return
            solved, solution = answer
            composed = result.compose(bind_input, wanted.positions, solved)
            self._is_settled, drag.answer = settles, composed
            if self._wanted is wanted:
                now = bpy.context.scene.frame_current
                drag.snaps.note(now, composed, wanted.positions, wanted.weights, bind_input.diagonal)
            if not settles:
                self.solve_seconds, self._shown = solution.timings["total"], wanted
                if self._wanted is not wanted and self._show_meanwhile(owner):
                    return
            was_drafted, drag.drafted = drag.drafted is not None, None
            if was_drafted:
                self._write(owner, composed)
            elif is_first and self._has_key(owner) and self._near(composed, shown, SAME_SHAPE):
                self._model(owner).wrote(shown)
            elif not (settles and self._near(composed, shown, SAME_TARGETS)):
                self._write(owner, composed)

        return lambda run: session.solve_steps(drag, wanted, settle=settles, execution=run), collect

    def _fail(self, obj, error, wanted):
        try:
            super()._fail(obj, error, wanted)
        finally:
            if self.problem is not None or self._binding is None:
                self.take_back(obj)

    def _show_meanwhile(self, obj):
        """Whether the mesh shows a draft of what is wanted."""
        if obj.mode in self.BUSY_MODES or obj.data.is_editmode or not self._is_read(obj):
            return False  # the mesh is another by now, or Blender has a copy of its own
        drag, wanted = self._drag, self._wanted
        if drag.binding is None:
            return self._show_early(obj)
        if wanted.weights is not None:
            return False
        if drag.drafted is not wanted:
            shape = session.draft(drag, wanted)
            if shape is None:
                return False
            self._write(obj, result.compose(self._input, wanted.positions, shape))
            drag.drafted = wanted
        return True

    def _start_next(self, obj, makes_keys, is_quiet):
        is_slow = self._binding is None and np.count_nonzero(self._input.solver_mesh.roi) >= session.EARLY_VERTICES
        if is_slow and self._is_quiet(obj) >= is_quiet:  # else who asks waits for the end
            if not makes_keys:
                return  # tick() does
            if self._drag.native is None:
                answer, drafted = self._before_draft(self._held(obj))
                self._drag = session.Drag(None, self._input, EarlyPoses(self._input, answer), answer, drafted)
                if self._show_early(obj):
                    return  # it is drawn before the bind begins
        super()._start_next(obj, makes_keys, is_quiet)

    def _show_early(self, obj):
        """As _show_meanwhile(), before and while the mesh is bound."""
        poses = self._drag.native
        found = poses and poses.next(obj, self._wanted, self._job and self._job.early)
        if found is not None:
            self._drag.drafted, shape = found
            self._write(obj, shape)
        return self._drag.drafted is self._wanted

    def _end_early(self):
        drag = self._drag
        if drag.binding is None and drag.native is not None:
            drag.native.stop()
            drag.native = None

    def _before_draft(self, shown):
        """(n x 3, the Targets of the draft that is shown in its place); (`shown`, None) where none is."""
        drag = self._drag
        if drag.drafted is None or len(drag.answer) != len(shown):
            return shown, None
        return drag.answer, drag.drafted

    def _near(self, first, second, share):
        return bool(np.abs(first - second).max(initial=0.0) <= share * self._input.diagonal)
