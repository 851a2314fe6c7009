# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices handles have that the add-on made, whatever becomes of the mesh."""

import bpy
import numpy as np
import pytest
from support import armatures, handles, libraries, meshes, steps
from support.handles import BOTTOM, TOP

RING = range(64, 72)


@pytest.fixture
def tube():
    """With handles of selected vertices: Head at the top, Feet at the bottom."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    for name, vertices in (("Head", TOP), ("Feet", BOTTOM)):
        make(obj, name, vertices)
    return obj


def make(obj, name, vertices, **options):
    steps.select_in_edit_mode(obj, vertices)
    assert bpy.ops.meanvalue.add_handle(name=name, **options) == {'FINISHED'}
    meshes.activate(obj)


def places(obj, name):
    return {tuple(np.round(obj.data.vertices[vertex].co, 4)) for vertex in steps.held(obj, name)}


def _separate(_obj):
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='DESELECT')
    bpy.ops.object.mode_set(mode='OBJECT')
    bpy.context.object.data.polygons[64].select = True
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.separate(type='SELECTED')
    bpy.ops.object.mode_set(mode='OBJECT')


def _join_one_with_a_handle(obj):
    other = meshes.tube(handles.RINGS, handles.SEGMENTS, "Other")
    other.location.x = 9.0
    make(other, "Head", RING)
    meshes.activate(obj)
    other.select_set(True)
    bpy.ops.object.join()


EDITS = {
    "edit mode": steps.in_edit_mode(lambda: None),
    "sort": steps.in_edit_mode(bpy.ops.mesh.sort_elements, type='RANDOMIZE', elements={'VERT'}),
    "normalize groups": lambda obj: (steps.add_group(obj, "Skin", range(50)), bpy.ops.object.vertex_group_normalize()),
    "rename": lambda obj: setattr(obj.meanvalue.handles["Head"], "name", "Skull"),
    "separate": _separate,
    "join": _join_one_with_a_handle,
    "copy": lambda obj: setattr(obj, "data", obj.data.copy()),
}


@pytest.mark.parametrize("edit", EDITS)
def test_handles_keep_their_vertices(tube, edit):
    before = [places(tube, name) for name in ("Head", "Feet")]
    EDITS[edit](tube)
    assert [places(tube, handle.name) for handle in tube.meanvalue.handles] == before


@pytest.mark.parametrize("cuts", [1, 2, 5])
def test_subdividing_gives_no_handle_vertices_of_others(tube, cuts):
    for number in range(4):
        make(tube, f"Ring {number}", range(8 * number + 8, 8 * number + 16))
    before = {handle.name: places(tube, handle.name) for handle in tube.meanvalue.handles}
    steps.in_edit_mode(bpy.ops.mesh.subdivide, number_cuts=cuts)(tube)
    for name, former in before.items():
        added = places(tube, name) - former
        heights = {place[2] for place in former}
        assert former <= places(tube, name) and len(added) == 8 * cuts, name
        assert {place[2] for place in added} == heights, "only between two of its own"


def test_a_vertex_of_two_handles_is_kept_by_both(tube):
    make(tube, "Both", [*TOP[:2], *RING])
    assert steps.held(tube, "Both") == sorted([*TOP[:2], *RING]) and steps.held(tube, "Head") == list(TOP)
    names = [each.name for each in tube.data.attributes if each.name.startswith("meanvalue")]
    assert len(names) == 2
    bpy.ops.meanvalue.remove_handle()
    assert [each.name for each in tube.data.attributes if each.name.startswith("meanvalue")] == names[:1]


@pytest.mark.parametrize("kind", [('FLOAT', 'POINT'), ('FLOAT2', 'CORNER')])
def test_an_attribute_of_another_kind_is_left_alone(tube, kind):
    tube.data.attributes.remove(tube.data.attributes["meanvalue_handles"])
    tube.data.attributes.new("meanvalue_handles", *kind)
    make(tube, "Ring", RING)
    assert [steps.held(tube, each.name) for each in tube.meanvalue.handles] == [[], [], [*RING]]
    other = tube.data.attributes["meanvalue_handles"]
    assert (other.data_type, other.domain) == kind


def test_names_are_unique(tube):
    tube.meanvalue.handles["Head"].name = "Feet"
    assert [handle.name for handle in tube.meanvalue.handles] == ["Feet.001", "Feet"]
    steps.add_group(tube, "Head", RING)
    meshes.activate(tube)
    bpy.ops.meanvalue.add_handle(group="Head")
    assert steps.held(tube, "Head") == list(RING) and steps.held(tube, "Feet.001") == list(TOP)


def test_appended_and_linked_duplicates_keep_them(tube, tmp_path):
    twin = meshes.duplicate(tube, linked=True)
    make(twin, "More", RING)
    meshes.activate(tube)
    bpy.ops.meanvalue.remove_handle()
    assert [steps.held(twin, handle.name) for handle in twin.meanvalue.handles] == [[*TOP], [*BOTTOM], [*RING]]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "made.blend"), copy=True)
    (obj,) = libraries.load(tmp_path / "made.blend", "objects", ["Tube"])
    assert [steps.held(obj, handle.name) for handle in obj.meanvalue.handles] == [[*TOP]]


def test_of_two_handles_on_one_group_the_one_whose_control_was_deleted_goes():
    obj, control = handles.tube()
    control.keyframe_insert("location", frame=1)
    second = obj.meanvalue.handles.add()
    second.name = "Top"
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}  # makes a control for it
    deleted = obj.meanvalue.handles[2].control
    assert deleted not in {None, control}
    bpy.data.objects.remove(deleted)
    make(obj, "Ring", RING)
    assert [handle.name for handle in obj.meanvalue.handles] == ["Bottom", "Top", "Ring"]
    assert obj.meanvalue.handles["Top"].control == control and control.animation_data.action.name in bpy.data.actions
    assert "Top" in obj.vertex_groups


def test_names_tell_where_handles_are(tube):
    for place, name in ((1.0, "Left Handle"), (-1.0, "Right Handle"), (0.0, "Handle")):
        vertex = min(RING, key=lambda number: abs(tube.data.vertices[number].co.x - place))
        bpy.ops.meanvalue.grab(vertex=vertex, size=0.01)
        assert tube.meanvalue.handles[-1].name == name
        meshes.activate(tube)
    steps.add_group(tube, "Spine", range(40, 100))
    make(tube, "", range(80, 88), pin=True)
    assert tube.meanvalue.handles[-1].name == "Spine Pin"
    # The fingertip's bone has the largest share.
    ends = {"Hand": (1.0, "Arm"), "Thumb": (2.0, "Hand"), "Tip": (3.0, "Hand")}
    bones = {name: ((0.0, 0.0, 0.0), (0.0, y, 0.0), parent) for name, (y, parent) in ends.items()}
    rig = armatures.make(Arm=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), **bones)
    tube.modifiers.new("Armature", 'ARMATURE').object = rig
    for bone, weight in (("Hand", 0.2), ("Thumb", 0.3), ("Tip", 0.45), ("Arm", 0.05)):
        steps.add_group(tube, bone, RING, weight)
    make(tube, "", RING)
    assert tube.meanvalue.handles[-1].name == "Hand Handle"
