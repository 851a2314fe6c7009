# SPDX-License-Identifier: GPL-3.0-or-later
"""Making the region of influence: grown from a handle, or painted."""

import bpy
import pytest
from support import meshes, steps
from support.steps import members

MIDDLE = 12
AROUND = [7, 11, 12, 13, 17]
WITHIN_TWO = [2, 6, 7, 8, 10, 11, 12, 13, 14, 16, 17, 18, 22]


def grid_with_handle(members=(MIDDLE,)):
    obj = meshes.grid()
    steps.list_anchors(obj, Handle=members)
    return obj


def grow(**options):
    assert bpy.ops.meanvalue.grow_region(**options) == {'FINISHED'}


@pytest.mark.parametrize(
    "distance, expected", [(0.0, [MIDDLE]), (1.2, AROUND), (2.1, WITHIN_TWO), (100.0, list(range(25)))]
)
def test_by_distance(distance, expected):
    obj = grid_with_handle()
    for each in (2.1, distance):  # growing again replaces the region
        grow(distance=each)
    assert members(obj, "Region") == expected and obj.vertex_groups.keys() == ["Handle", "Region"]


def test_distance_is_measured_on_the_rest_shape_without_the_objects_scale():
    obj = grid_with_handle()
    obj.scale = (10.0, 10.0, 10.0)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="Far")
    steps.move(obj, range(0, 25, 2), (50.0, 0.0, 0.0), key)
    grow(distance=1.2)
    assert members(obj, "Region") == AROUND


def test_a_distance_that_was_never_given_fits_the_mesh():
    for size in (1.0, 100.0):
        obj = meshes.grid(columns=11, rows=11)
        for vertex in obj.data.vertices:
            vertex.co *= size
        steps.list_anchors(obj, Handle=[60])
        grow()
        assert 5 < len(members(obj, "Region")) < 60


def test_extend_keeps_a_falloff_and_the_artists_own_group():
    obj = grid_with_handle()
    steps.add_group(obj, "Soft", [0, MIDDLE], 0.4)
    obj.meanvalue.roi_group = "Soft"
    grow(distance=1.2, extend=True)
    assert obj.meanvalue.roi_group == "Region" and members(obj, "Soft") == [0, MIDDLE]
    assert members(obj, "Region") == sorted({0, *AROUND})
    region = obj.vertex_groups["Region"]
    assert region.weight(0) == pytest.approx(0.4, abs=2 / 255) and region.weight(MIDDLE) == 1.0


def test_the_group_in_the_settings_is_used_and_a_stranger_called_region_is_not():
    obj = grid_with_handle()
    steps.add_group(obj, "Region", [3, 4])
    grow(distance=1.2)
    assert obj.meanvalue.roi_group == "Region.001"
    assert members(obj, "Region") == [3, 4]
    obj.meanvalue.roi_group = "Gone"
    grow(distance=1.2)
    assert members(obj, "Gone") == AROUND


@pytest.mark.parametrize(
    "prepare, texts",
    [
        (lambda obj: obj.meanvalue.handles.clear(), ("no active handle", "Add Handle")),
        (lambda obj: obj.vertex_groups.remove(obj.vertex_groups["Handle"]), ("no vertex group 'Handle'",)),
        (lambda obj: obj.vertex_groups["Handle"].remove(range(25)), ("'Handle' has no vertices", "Assign some")),
        (lambda obj: setattr(obj.meanvalue, "roi_group", "Handle"), ("vertex group of a handle", "clear the field")),
        (lambda obj: bpy.ops.object.mode_set(mode='EDIT'), ("is in Edit Mode", "Object Mode")),
    ],
)
def test_refused(prepare, texts):
    obj = grid_with_handle()
    prepare(obj)
    with steps.refused(*texts, unchanged=obj):
        bpy.ops.meanvalue.grow_region()


# -- painting --------------------------------------------------------------------------------------------------------


def test_painting_makes_the_group_and_goes_back():
    obj = grid_with_handle()
    assert bpy.ops.meanvalue.paint_region() == {'FINISHED'}
    assert obj.mode == 'WEIGHT_PAINT'
    assert obj.vertex_groups.active.name == obj.meanvalue.roi_group == "Region"
    obj.vertex_groups["Region"].add(AROUND, 0.4, 'REPLACE')
    assert bpy.ops.meanvalue.paint_region() == {'FINISHED'}
    assert obj.mode == 'OBJECT'
    assert members(obj, "Region") == AROUND


def test_painting_a_region_that_is_there_keeps_it_as_it_is():
    obj = grid_with_handle()
    steps.add_group(obj, "Arm", AROUND)
    steps.add_group(obj, "Last", [0])
    obj.meanvalue.roi_group = "Arm"
    assert bpy.ops.meanvalue.paint_region() == {'FINISHED'}
    assert obj.vertex_groups.active.name == "Arm"
    assert members(obj, "Arm") == AROUND


def test_painting_while_the_control_is_active_paints_the_mesh():
    obj = meshes.grid()
    steps.add_handle(obj, "Hand", [MIDDLE], live=False)
    assert bpy.ops.meanvalue.paint_region() == {'FINISHED'}
    assert bpy.context.object == obj
    assert obj.mode == 'WEIGHT_PAINT'


@pytest.mark.parametrize("is_hidden, text", [(True, "is hidden"), (False, "vertex group of a handle too")])
def test_a_hidden_mesh_and_a_handles_group_are_not_painted(is_hidden, text):
    obj = grid_with_handle()
    obj.hide_set(is_hidden)
    obj.meanvalue.roi_group = "" if is_hidden else "Handle"
    bpy.context.view_layer.objects.active = obj
    with steps.refused(text, unchanged=obj):
        bpy.ops.meanvalue.paint_region()
