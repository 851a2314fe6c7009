# SPDX-License-Identifier: GPL-3.0-or-later
"""Live turned on and off by its shortcut, which is Blender's own operator."""

import bpy
import pytest
from support import meshes, steps


def grid_with_handle():
    obj = meshes.grid()
    steps.add_handle(obj, "Rest", [0, 4, 20], pin=True)
    steps.add_handle(obj, "Hand", [24], live=False)
    return obj


def toggle():
    assert bpy.ops.wm.context_toggle(data_path="scene.meanvalue_live") == {'FINISHED'}


@pytest.mark.parametrize("active", ["mesh", "control"])
def test_on_and_off(active):
    obj = grid_with_handle()
    meshes.activate(obj if active == "mesh" else obj.meanvalue.handles["Hand"].control)
    toggle()
    assert obj.meanvalue.live
    toggle()
    assert not obj.meanvalue.live


def test_nothing_is_turned_on_without_handles():
    obj = meshes.grid()
    toggle()
    assert not obj.meanvalue.live
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    bpy.context.collection.objects.link(lamp)
    meshes.activate(lamp)
    toggle()
