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
        if control_places.follows_rig(obj, handle):
            control_places.set_frame(handle, control_places.unscaled(obj))
    bpy.context.view_layer.update()
    handles = sorted(handles, key=_depth)
    for _ in range(MOST_RESETS):
        transforms = _follow_rig(obj, handles)
        if not _elsewhere(obj, handles, transforms):
            break
        for handle, transform in zip(handles, transforms, strict=True):  # all: what is reset takes its children along
            control_places.put(handle, np.array(obj.matrix_world) @ transform @ control_places.at_rest(handle))
            bpy.context.view_layer.update()  # the next may be a child of this one
        if not rig_space.is_there(obj):
            break
    return _elsewhere(obj, handles, _follow_rig(obj, handles))


def _depth(handle):
    """How many parents the control has: those are reset before it."""
    control = handle.control
    bone = control.pose.bones.get(handle.bone) if control.type == 'ARMATURE' and handle.bone else None
    count = len(bone.parent_recursive) if bone is not None else 0
    while control.parent is not None:
        control, count = control.parent, count + 1
    return count


def _follow_rig(obj, handles):
    """[4 x 4]: the transforms of now, which controls that go along with the rig have followed."""
    transforms = control_places.rig_transforms(obj, handles)
    for handle, transform in zip(handles, transforms, strict=True):
        control_places.follow_rig(obj, handle, transform)
    bpy.context.view_layer.update()
    return transforms


def _elsewhere(obj, handles, transforms):
    return [
        handle
        for handle, transform in zip(handles, transforms, strict=True)
        if controls.move(obj, handle, transform) is not motion.IDENTITY
    ]
