# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts controls back to where their handles are at rest."""

import bpy
import numpy as np

from ...scene import rig_space
from ...scene.core import motion
from . import control_places, controls

#: A bone that deforms its own handle by half has moved it by half of what is missing each time that it is put back.
MOST_RESETS = 24


def reset(obj, handles):
    """Puts controls back to where their handles are in the rest shape. Returns those of `handles` that are elsewhere.

    Those that Add Handle made take the scale that the object has now: a turn of them would shear else.
    """
    for handle in handles:
        if control_places.goes_along(obj, handle):
            control_places.take_frame(handle, control_places.unscaled(obj))
    bpy.context.view_layer.update()
    handles = sorted(handles, key=_depth)
    for _ in range(MOST_RESETS):
        carries = _go_along(obj, handles)
        if not _elsewhere(obj, handles, carries):
            break
        for handle, carry in zip(handles, carries, strict=True):  # all: what is reset takes its children along
            control_places.put(handle, np.array(obj.matrix_world) @ carry @ control_places.at_rest(handle))
            bpy.context.view_layer.update()  # the next may be a child of this one
        if not rig_space.is_there(obj):
            break
    return _elsewhere(obj, handles, _go_along(obj, handles))


def _depth(handle):
    """How many parents the control has: those are reset before it."""
    control = handle.control
    bone = control.pose.bones.get(handle.bone) if control.type == 'ARMATURE' and handle.bone else None
    count = len(bone.parent_recursive) if bone is not None else 0
    while control.parent is not None:
        control, count = control.parent, count + 1
    return count


def _go_along(obj, handles):
    """[4 x 4]: the carries of now, which controls that go along with the rig have followed."""
    carries = control_places.carries(obj, handles)
    for handle, carry in zip(handles, carries, strict=True):
        control_places.go_along(obj, handle, carry)
    bpy.context.view_layer.update()
    return carries


def _elsewhere(obj, handles, carries):
    return [
        handle
        for handle, carry in zip(handles, carries, strict=True)
        if controls.move(obj, handle, carry) is not motion.IDENTITY
    ]
