# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the handles of a live object are wanted, poses of one that is still being bound, and where a pose snaps."""

import contextlib

import numpy as np

from ...errors import MeanValueError, require_none
from ...live import following
from ...scene import rig_space
from ...scene.core import motion
from ...solver import native_loader, session
from ...solver.core import result
from ...solver.job import Job
from ..bridge import region, scene_input, targets


class LiveTargets:
    """Where the anchors are wanted, behind a rig that may move at any time.

    What the rig does is measured when it is quiet, or right before a solve that needs it; never at each step of a drag.
    A handle whose control stays where it was beside the rig keeps its targets, so that a rig that moves changes no key.
    """

    def __init__(self):
        self._measured = None, None  # revision of the rig, and what rig_space.measure() gave then
        self._gone_along = None  # revision for which controls were put to where it has their handles
        self._known = {}  # see targets.positions()

    def is_behind(self, obj):
        """Whether the rig may have moved since controls that go along with it did so."""
        return self._gone_along != _revision(obj)

    def gather(self, obj, bind_input, former):
        """The Targets of `obj`; former: those before, or None. @throws SceneError."""
        require_none(targets.problem(obj))
        if self._measured[0] != _revision(obj):
            if former is not None:
                goal, known = self._behind(obj, bind_input)
                if goal.is_near(former, motion.NOISE * bind_input.diagonal):
                    self._known = known
                    return goal
            self._measure(obj)
        goal, self._known = self._behind(obj, bind_input)
        return goal

    def catch_up(self, obj, bind_input):
        """Has the controls that go along with the rig do so, which is measured if need be. @throws SceneError."""
        if self._measured[0] != _revision(obj):
            self._measure(obj)
        targets.follow_rig(obj, bind_input, self._measured[1])
        self._gone_along = self._measured[0]

    def _measure(self, obj):
        space = rig_space.measure(obj)
        self._measured = _revision(obj), space

    def _behind(self, obj, bind_input):
        """(Targets, what is known of handles then). Without a rig nothing is kept. @throws SceneError."""
        known, space = dict(self._known), self._measured[1]
        is_kept = space is not None or known
        return targets.gather_behind(obj, bind_input, space, known if is_kept else None), known


def _revision(obj):
    """Another one where the rig may be."""
    model = scene_input.model(obj)
    return model.rig_revision, model.content, rig_space.sliders(obj)


#: They take a sixth of the time: binding wants the processor too.
RESTS = 5.0


class EarlyPoses:
    """Shapes while a mesh is bound: solves by what that offers early, and sketches from each on (decision 35)."""

    def __init__(self, bind_input, shape):
        self._known = shape[bind_input.anchors].astype(np.float64), shape  # where anchors are, and all is
        self._input, self._job, self._shown, self._weights = bind_input, None, None, {}
        self._rests_until = 0.0

    def next(self, obj, wanted, deformer):
        """(Targets, n x 3 float32) of what there is new to show, else None. deformer: what the bind offers, or None."""
        found, noise = None, motion.NOISE * self._input.diagonal
        if self._job is not None and self._job.is_finished:
            job, self._job, seconds = self._job, None, following.SLOW_SECONDS
            with contextlib.suppress(MeanValueError):  # the answer says why
                solved, solution = job.result()
                found, seconds = job.of, RESTS * solution.timings["total"]
                self._known = found.positions, result.compose(self._input, found.positions, solved)
                found = found, self._known[1]
            self._rests_until = following.clock() + seconds
        moved = np.unique(self._input.handles[np.abs(wanted.positions - self._known[0]).max(axis=1) > noise])
        if deformer is not None and self._job is None and following.clock() >= self._rests_until and len(moved):
            drag = session.Drag(None, self._input, deformer)
            self._job = Job(lambda run: session.solve_steps(drag, wanted, execution=run), of=wanted)
        if wanted is not self._shown or found is not None:
            sketch, self._shown = self._sketch(obj, wanted, moved), wanted
            found = found if sketch is None else (wanted, sketch)
        return found

    def _sketch(self, obj, wanted, moved):
        """n x 3 float32: what `moved`, numbers of handles, reach goes along, the less the farther. None if unknown."""
        before, shape = self._known
        if self._input.planes is not None or wanted.weights is not None or len(moved) == 0:
            return None
        handles, found = targets.enabled_handles(obj), shape.copy()
        for number in moved:
            if number not in self._weights:
                self._weights[number] = region.around(obj, handles[number]) * self._input.roi
            held, members = self._input.handles == number, np.flatnonzero(self._weights[number])
            if len(members) == 0:
                return None
            move, points = motion.fitted(before[held], wanted.positions[held]), shape[members]
            found[members] += self._weights[number][members, None] * (motion.apply(move, points) - points)
        found[self._input.anchors] = wanted.positions
        return found

    def stop(self):
        if self._job is not None:
            self._job.drop()


#: Frames to either side that tell whether a step is a snap, and the fewest in a row that tell anything.
ASIDE, FEWEST = 8, 6

#: Vertices and anchors that are looked at.
MOST_ROWS, MOST_ANCHORS = 2000, 100

#: Targets at the same frame that differ by more, as a share of the size, are of another animation.
SAME = 1e-4


class SnapWatch:
    """Looks at answers at frames in a row. found: the one that the pose snaps at from the one before, or None."""

    def __init__(self):
        self.found = None
        self._last = {}  # frame: (rows of the shape, targets of anchors, their weights)

    def note(self, frame, shape, targets, weights, diagonal):
        """shape: n x 3, the answer at this frame; targets, weights: k x 3, and k or None."""
        every = max(1, len(targets) // MOST_ANCHORS)
        asked = targets[::every], np.ones(len(targets[::every])) if weights is None else weights[::every]
        if frame in self._last and np.abs(asked[0] - self._last[frame][1]).max(initial=0.0) > SAME * diagonal:
            self._last, self.found = {}, None
        self._last[frame] = (shape[:: max(1, len(shape) // MOST_ROWS)].copy(), *asked)
        if not {frame - 1, frame + 1} & self._last.keys():
            self._last = {frame: self._last[frame]}
        frames = [each for each in sorted(self._last) if abs(each - frame) <= 2 * ASIDE]
        self._last = {each: self._last[each] for each in frames}
        if len(frames) < FEWEST:
            return
        shapes, targets, weights = (np.stack(each) for each in zip(*self._last.values(), strict=True))
        told = native_loader.module().find_snaps(shapes, targets, diagonal, weights=weights)
        near = [frames[0] + each for each in told if abs(frames[0] + each - frame) <= ASIDE]
        if near or (self.found is not None and abs(self.found - frame) <= ASIDE):
            self.found = max(near, default=None)
