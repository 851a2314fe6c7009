# SPDX-License-Identifier: GPL-3.0-or-later
"""Base of the operators that use the pose that is shown: where it is live, it must not lag behind its controls."""

from ...errors import SceneError
from ...live import engine
from ...scene import shape_keys
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import scene_input
from ..bridge.posing import Posing


class SettledOperator(BackgroundOperator):
    """Mix-in: subclasses define use(obj) in place of run(obj); it finds the settled answer in the result key."""

    doing = "Settling"

    def start_reading(self, obj):
        return None if _is_settled(obj) else scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        return NothingToDo() if _is_settled(obj) else Posing.to_settle(obj, reading)

    def finish(self, obj, prepared, outcome):
        if outcome is not None:
            solved, _summary = outcome
            prepared.keep()
            goal = prepared.targets
            composed = result.compose(prepared.bind_input, goal.positions, solved)
            shape_keys.write_result(obj, composed)
        return self.use(obj)


def unposed_problem(obj):
    """Why there is no pose to use, in words, or None."""
    if shape_keys.has_result(obj):
        return None
    return "Nothing is posed yet. Press on the mesh with Grab and drag"


class NothingToDo:
    """In place of a Posing where the answer is there."""

    def read_triangles(self, _obj):
        pass

    def work(self, _execution):
        return None
        yield  # nothing: no steps

    def require_unchanged(self, obj, _reading):
        if not _is_settled(obj):
            raise SceneError(f"'{obj.name}' was posed anew meanwhile. Try again")


def _is_settled(obj):
    """A mix of shape keys has no say in the pose."""
    return not obj.meanvalue.live or engine.is_settled(obj)
