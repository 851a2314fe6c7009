# SPDX-License-Identifier: GPL-3.0-or-later
"""What the operators that use the pose that is shown have in common."""

from ...errors import SceneError
from ...live import engine
from ...scene import shape_keys
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import scene_input
from ..bridge.posing import CONTROLS, Posing


class SettledOperator(BackgroundOperator):
    """Mix-in of those that use the pose that is shown: where it is live, it must not lag behind its controls.

    Subclasses define use(obj) in place of run(obj); it finds the settled answer in the result key.
    """

    doing = "Settling"

    def start_reading(self, obj):
        return None if _is_settled(obj) else scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        return None if _is_settled(obj) else Posing(obj, reading, CONTROLS, is_checked=False, settles=True)

    def finish(self, obj, prepared, outcome):
        if prepared is not None:
            solved, _summary = outcome
            prepared.keep()
            goal = prepared.targets
            composed = result.compose(prepared.bind_input, goal.positions, solved)
            shape_keys.write_result(obj, composed)
        elif not _is_settled(obj):
            raise SceneError(f"A handle of '{obj.name}' was moved meanwhile. Try again")
        return self.use(obj)


def unposed_problem(obj):
    """Why there is no pose to use, in words, or None."""
    if shape_keys.has_result(obj):
        return None
    return "Nothing is posed yet. Press on the mesh with Grab and drag"


def _is_settled(obj):
    """A mix of shape keys has no say in the pose."""
    return not obj.meanvalue.live or engine.is_settled(obj)
