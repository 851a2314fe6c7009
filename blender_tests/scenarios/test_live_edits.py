# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever is edited while Live is on: the next drag shows what binding and solving anew gives, or tells why not."""

import bpy
import numpy as np
import pytest
from support import handles, meshes, rigs
from support.handles import move, shown, update


def edit_mode(obj):
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.object.mode_set(mode='OBJECT')


def paint_mode(obj):
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
    bpy.ops.object.vertex_group_normalize_all(lock_active=False)
    bpy.ops.object.mode_set(mode='OBJECT')


EDITS = {
    "group": lambda obj: obj.vertex_groups["Top"].remove([handles.TOP[0]]),
    "weight": lambda obj: setattr(obj.data.vertices[0].groups[0], "weight", 0.0),
    "point of the rest shape": lambda obj: setattr(obj.data.shape_keys.reference_key.data[60], "co", (0.0, 0.0, 5.0)),
    "setting": lambda obj: setattr(obj.meanvalue, "rigidity", 3.0),
    "edit mode": edit_mode,
    "weight paint": paint_mode,
    "modifier": lambda obj: obj.modifiers.new("Smooth", 'SMOOTH'),
}


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS.keys())
def test_edits(part, edit):
    obj, _rig = rigs.posed_arm()
    control = obj.meanvalue.handles["Top"].control
    move(control, (0.5, 0.0, 0.0))
    edit(obj)
    update()
    move(control, (0.5, 0.0, 0.0))
    if (part("live.engine").status(obj) or ("", False))[1]:
        return
    live = shown(obj)
    obj.meanvalue.live = False
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert np.abs(shown(obj) - live).max() < 5e-2
