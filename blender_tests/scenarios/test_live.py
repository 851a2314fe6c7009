# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing as far as it can be had without a window: the mesh follows whatever moves its controls."""

import math

import bpy
import numpy as np
import pytest
from support import armatures, handles, installed, libraries, meshes, steps
from support.handles import BOTTOM, TOP, is_at_rest, move, rest, shown, update

#: Two answers that are both converged differ no more, as a share of the bounding-box diagonal (about 10 here).
SAME = 5e-3


def test_the_mesh_follows_at_once():
    obj, control = handles.tube()
    assert obj.meanvalue.live and is_at_rest(obj)
    move(control, (2.0, 0.0, -1.0))
    expected = rest(obj)[TOP] + np.array((2.0, 0.0, -1.0), np.float32)
    assert np.abs(shown(obj)[TOP] - expected).max() < 1e-5
    assert np.array_equal(shown(obj)[BOTTOM], rest(obj)[BOTTOM])
    middle = shown(obj)[handles.RINGS // 2 * handles.SEGMENTS] - rest(obj)[handles.RINGS // 2 * handles.SEGMENTS]
    assert 0.2 < middle[0] < 1.8


def test_the_way_of_the_drag_does_not_matter():
    obj, control = handles.tube()
    for step in range(1, 13):
        control.rotation_mode = 'XYZ'
        control.rotation_euler = (0.0, math.radians(90.0) * step / 12, 0.0)
        control.location = (3.0 * step / 12, 0.0, 9.6 - 4.0 * step / 12)
        update()
    dragged = shown(obj)
    obj.meanvalue.live = False
    assert bpy.ops.meanvalue.solve() == {'FINISHED'}
    assert np.abs(shown(obj) - dragged).max() < SAME


def test_live_off_leaves_the_mesh_alone():
    obj, control = handles.tube(live=False)
    assert not obj.meanvalue.live
    move(control, (2.0, 0.0, -1.0))
    assert obj.data.shape_keys is None
    obj.meanvalue.live = True
    update()
    assert not is_at_rest(obj)
    obj.meanvalue.live = False
    before = shown(obj)
    move(control, (2.0, 0.0, -1.0))
    assert np.array_equal(shown(obj), before)


def test_a_bone_carries_a_handle():
    obj, _control = handles.tube()
    armature = armatures.make(Hand=((0.0, 0.0, 9.6), (0.0, 0.0, 11.0)))
    bpy.ops.object.mode_set(mode='POSE')
    handle = obj.meanvalue.handles["Top"]
    handle.control = armature
    handle.bone = "Hand"
    update()
    assert is_at_rest(obj)
    assert bpy.ops.meanvalue.bind.poll()  # the mesh is worked on while the armature is active
    armature.pose.bones["Hand"].location = (0.0, 0.0, 2.0)  # in the bone's own axes: its z is the world's -y
    update()
    expected = rest(obj)[TOP] + np.array(
        armature.pose.bones["Hand"].matrix.translation - armature.data.bones["Hand"].head_local, np.float32
    )
    assert np.abs(expected - rest(obj)[TOP]).max() > 1.0
    assert np.abs(shown(obj)[TOP] - expected).max() < 1e-4


def test_settings_are_followed():
    obj, control = handles.tube()
    move(control, (3.0, 0.0, -2.0))
    stiff = shown(obj)
    obj.meanvalue.rigidity = 0.5
    update()
    assert np.abs(shown(obj) - stiff).max() > 1e-3
    obj.meanvalue.rigidity = 15.0
    update()
    assert np.abs(shown(obj) - stiff).max() < SAME


def test_a_handle_that_is_off_holds_nothing():
    obj, control, middle = handles.three_handles()
    move(control, (3.0, 0.0, 0.0))
    assert np.array_equal(shown(obj)[middle], rest(obj)[middle])
    obj.meanvalue.handles["Middle"].is_enabled = False
    update()
    assert np.abs(shown(obj)[middle] - rest(obj)[middle]).max() > 0.3


def test_another_topology_stops_it_until_bind(status):
    obj, control = handles.tube()
    move(control, (2.0, 0.0, 0.0))
    meshes.activate(obj)
    steps.edit_mesh(obj, lambda edited: edited.verts.new((0.0, 0.0, -3.0)))
    before = shown(obj)
    move(control, (1.0, 0.0, 0.0))
    text, is_problem = status(obj)
    assert is_problem and "Update" in text
    assert np.array_equal(shown(obj), before)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    update()
    assert status(obj)[1] is False
    assert np.abs(shown(obj) - before)[:-1].max() < 1e-4  # Update moves nothing
    move(control, (1.0, 0.0, 0.0))
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 3.0).max() < 1e-4


def test_a_handle_goes_with_its_control(status):
    """X in the 3D View; what is left follows the others."""
    obj, control, _middle = handles.three_handles()
    move(control, (2.0, 0.0, 0.0))
    meshes.activate(obj)
    steps.add_handle(obj, "Side", range(40, 44))
    update()
    meshes.activate(bpy.context.object)
    bpy.ops.object.delete()
    update()
    assert status(obj)[1] is False, status(obj)
    move(control, (0.0, 1.0, 0.0))
    assert np.abs(shown(obj)[TOP] - rest(obj)[TOP] - (2.0, 1.0, 0.0)).max() < 1e-4
    steps.run(obj, "bind")
    assert "Side" not in obj.meanvalue.handles


def test_a_duplicate_asks_for_controls_of_its_own(status):
    obj, control = handles.tube()
    move(control, (2.0, 0.0, 0.0))
    meshes.activate(obj)
    bpy.ops.object.duplicate()
    copy = bpy.context.object
    update()
    assert f"belongs to '{obj.name}'" in status(copy)[0]
    before = shown(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    update()
    assert status(copy)[1] is False
    move(copy.meanvalue.handles["Top"].control, (0.0, 0.0, 1.0))
    assert np.array_equal(shown(obj), before)
    assert np.abs(shown(copy)[TOP, 2] - rest(copy)[TOP, 2] - 1.0).max() < 1e-4


@pytest.mark.parametrize("link", [False, True])
def test_taken_into_another_file(tmp_path, link):
    obj, control = handles.tube()
    move(control, (2.0, 0.0, -1.0))
    before = shown(obj)
    path = str(tmp_path / "live.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    installed.enable()
    obj = next(each for each in libraries.load(path, "objects", link=link) if each.type == 'MESH')
    update()
    move(obj.meanvalue.handles["Top"].control, (1.0, 0.0, 0.0))
    if link:
        assert np.array_equal(shown(obj), before)
    else:
        assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 3.0).max() < 1e-4


def test_disabled_while_live_nothing_is_left_and_enabled_it_goes_on():
    obj, control = handles.tube()
    move(control, (2.0, 0.0, 0.0))
    before = shown(obj)
    installed.disable()
    move(control, (1.0, 0.0, 0.0))
    assert np.array_equal(shown(obj), before)
    installed.enable()
    move(control, (1.0, 0.0, 0.0))
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 4.0).max() < 1e-4


def test_a_soft_handle_gives_way_by_its_strength():
    obj, control = handles.tube()
    handle = obj.meanvalue.handles["Top"]
    reached = []
    for strength in (0.0, 0.5, 1.0):
        handle.is_soft, handle.strength = True, strength
        control.location.x = 3.0
        update()
        reached.append(float((shown(obj)[TOP, 0] - rest(obj)[TOP, 0]).mean()))
    handle.is_soft = False
    update()
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 3.0).max() < 1e-4
    assert reached[0] < reached[1] < reached[2]
    assert reached[0] < 1.0 and 1.0 < reached[1] < 2.9 and 2.7 < reached[2] < 3.0, reached
