# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns live posing on and off."""

import bpy

from ...errors import SceneError
from ...scene import subject
from ...widgets.base import MeshOperator
from ..bridge import scene_input, targets


class MEANVALUE_OT_toggle_live(MeshOperator, bpy.types.Operator):
    """Turn Live on or off: whether the mesh follows its handles at once"""

    bl_idname = "meanvalue.toggle_live"
    bl_label = "Toggle Live"
    needs_object_mode = False

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.live:
            problem = subject.mode_problem(obj)
        return problem

    def run(self, obj):
        settings = obj.meanvalue
        if settings.live:
            settings.live = False
            return f"Live is off: '{obj.name}' stays as it is", []
        problem = _problem(obj)
        if problem:
            raise SceneError(f"Live stays off: {problem}")
        settings.live = True
        return f"Live is on: '{obj.name}' follows its handles", []


def _problem(obj):
    """Why the mesh could not follow, in words, or None."""
    try:
        scene_input.gather(obj, scene_input.model(obj).reading)
    except SceneError as error:
        return str(error)
    return targets.problem(obj)
