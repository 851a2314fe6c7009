# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses of a mesh that is still being bound."""

import functools

from ...errors import MeanValueError
from ...live import following
from ...solver import session
from ...solver.job import Job

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
                solve = functools.partial(session.solve_steps, self._solver, wanted)
                self._job = Job(lambda execution: solve(execution=execution), of=wanted)
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
