# SPDX-License-Identifier: GPL-3.0-or-later
"""What Wrap hands to the solver."""

import bpy
import numpy as np

from ...errors import SceneError, SolverError
from ...solver import native_loader, session
from ...solver.core import result
from ...solver.core.fingerprint import digest
from ..core.wrapping import Wrap
from . import wrap_scene


class Wrapping:
    """In place of a Posing for widgets/background.py."""

    def __init__(self, given, target_name):
        self.target_name = target_name
        self.given = given
        self._wrap = Wrap(given)

    @property
    def share(self):
        return self._wrap.share

    def read_triangles(self, _obj):
        pass

    def work(self, execution):
        """Steps (see solver/job.py) to a Wrapped. @throws MeanValueError."""

        def bind(rest, triangles, anchors, strengths):
            task = session.call(
                native_loader.module().start_bind, rest, triangles, anchors, strengths=strengths, execution=execution
            )
            yield task
            return session.call(task.result)

        def solve(deformer, targets, weights=None, start=None, tolerance=None):
            task = session.call(
                deformer.start_solve,
                np.ascontiguousarray(targets),
                weights=weights,
                start=start,
                tolerance=tolerance,
                execution=execution,
                refused=session.REFUSED_POSE,
            )
            yield task
            vertices = session.call(task.result, refused=session.REFUSED_POSE).vertices
            if not result.all_finite(vertices):
                raise SolverError("The solver gave positions that are not numbers. Pick more pairs of points")
            return vertices

        return (yield from self._wrap.steps(bind, solve))

    def require_unchanged(self, obj, _reading):
        """@throws SceneError if one of both meshes is another by now."""
        target = bpy.data.objects.get(self.target_name)
        if target is None or _key(wrap_scene.gather(obj, target)) != _key(self.given):
            raise SceneError(
                f"'{obj.name}' or '{self.target_name}' was changed meanwhile, so the result is dropped. Try again"
            )


def _key(given):
    return digest(given.vertices, given.triangles, given.target, given.target_triangles, given.picked, given.points)
