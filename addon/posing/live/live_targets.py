# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the handles of a live object are wanted, and poses of one that is still being bound."""

from ...errors import MeanValueError, require_none
from ...live import following
from ...scene import rig_space
from ...scene.core import motion
from ...solver import session
from ...solver.job import Job
from ..bridge import scene_input, targets


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
        """Has the controls that go along with the rig do so, and measures what it does if that is not known.

        @throws SceneError.
        """
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
    """One solve after another by what a bind has to offer early: decision 35. rests_until: 0 until one is done."""

    def __init__(self, deformer, bind_input):
        self._solver = session.Drag(None, bind_input, deformer, None)
        self._job = None
        self.rests_until = 0.0

    def next(self, wanted):
        """(Targets, n x 3) of a solve that is done, else None; begins one of `wanted` when it is time."""
        if self._job is None:
            if following.clock() >= self.rests_until:
                self._job = Job(lambda run: session.solve_steps(self._solver, wanted, execution=run), of=wanted)
            return None
        if not self._job.is_finished:
            return None
        job, self._job = self._job, None
        try:
            solved, solution = job.result()
        except MeanValueError:  # the answer says why
            self.rests_until = following.clock() + following.SLOW_SECONDS
            return None
        self.rests_until = following.clock() + RESTS * solution.timings["total"]
        return job.of, solved

    def stop(self):
        if self._job is not None:
            self._job.drop()
