# SPDX-License-Identifier: GPL-3.0-or-later
"""Bend At: limbs bend at the joints of their rig, or as kept poses do."""

import bpy
import numpy as np
import pytest
from support import bent_tubes, handles, meshes, rigs, steps
from support.installed import part

RINGS = np.arange(rigs.RINGS * rigs.SEGMENTS).reshape(rigs.RINGS, -1)


def told(obj):
    """What the panel shows."""
    reading = part("posing.bridge.scene_input")
    found = reading.gather(obj)
    return (reading.known(obj) or found).bends


def pushed(obj, control):
    """How much of its length the upper half has lost or gained after the hand was pushed."""
    handles.move(control, (4.0, 0.0, -3.0))
    shapes = handles.rest(obj), handles.shown(obj)
    rest, shown = (np.linalg.norm(each[RINGS[5]].mean(0) - each[RINGS[1]].mean(0)) for each in shapes)
    return abs(shown / rest - 1.0)


def test_the_first_handle_of_a_mesh_on_a_rig_has_it_bend_at_the_joints():
    obj, _armature = rigs.arm()
    control = rigs.held(obj, "Top", rigs.TOP)
    assert obj.meanvalue.bend_at == 'RIG' and told(obj) == "Bends at 1 joint of 'Rig'"
    at_joint = pushed(obj, control)
    shown = handles.shown(obj)
    obj.meanvalue.bend_at = 'EVERYWHERE'
    handles.update()
    assert np.abs(handles.shown(obj) - shown).max() > 1e-2
    obj.meanvalue.bend_at = 'RIG'
    handles.update()
    assert np.abs(handles.shown(obj) - shown).max() < 2e-4 * rigs.size(obj)
    obj.meanvalue.bend_at = 'EVERYWHERE'
    handles.move(control, (-4.0, 0.0, 3.0))
    assert at_joint < 0.6 * pushed(obj, control)


def test_a_choice_and_what_has_handles_already_is_left_as_it_is():
    obj, _control = handles.tube()
    assert obj.meanvalue.bend_at == 'EVERYWHERE'
    obj, _armature = rigs.arm()
    obj.meanvalue.bend_at = 'EVERYWHERE'
    rigs.pin(obj, "Bottom", rigs.BOTTOM)
    assert obj.meanvalue.bend_at == 'EVERYWHERE' and told(obj) == ""


@pytest.mark.parametrize("change", ["renamed bone", "hidden", "moved", "a second modifier", "stray group", "parent"])
def test_joints_are_found_however_the_rig_stands(change):
    obj, armature = rigs.arm()
    rigs.pin(obj, "Bottom", rigs.BOTTOM)
    expected = part("posing.bridge.scene_input").gather(obj).stiffness
    if change == "renamed bone":
        armature.data.bones["Lower"].name = "Forearm"
    elif change == "hidden":
        armature.hide_viewport = True
    elif change == "moved":
        armature.location, armature.scale = (3.0, 4.0, 5.0), (2.0, 2.0, 2.0)
    elif change == "a second modifier":
        obj.modifiers.new("Again", 'ARMATURE').object = armature
    elif change == "stray group":
        steps.add_group(obj, "No bone", range(40))
    else:
        obj.modifiers.clear()
        obj.parent, obj.parent_type = armature, 'ARMATURE'
    meshes.activate(obj)
    handles.update()
    found = part("posing.bridge.scene_input").gather(obj)
    assert np.array_equal(found.stiffness, expected) and expected.max() == 30.0 and expected.min() == 1.0
    assert found.bends == f"Bends at 1 joint of '{armature.name}'"


def test_without_weights_it_says_so_and_bends_everywhere():
    obj, armature = rigs.arm()
    rigs.pin(obj, "Bottom", rigs.BOTTOM)
    for bone in armature.data.bones:
        bone.use_deform = False
    handles.update()
    found = part("posing.bridge.scene_input").gather(obj)
    assert found.stiffness is None and found.bends.startswith("No bone of a rig has weights")


def test_kept_poses_tell_from_two_on():
    obj, control = handles.tube()
    assert told(obj) == ""
    obj.meanvalue.bend_at = 'POSES'
    texts = [told(obj)]
    for _ in range(2):
        handles.move(control, (2.0, 0.0, -1.0))
        assert bpy.ops.meanvalue.keep_pose() == {'FINISHED'}
        handles.update()
        texts.append(told(obj))
    assert texts[0] == texts[1] == "Keep 2 poses that bend its joints: until then it bends everywhere"
    assert texts[2] == "No kept pose bends it more in one place than in others: it bends everywhere"
    rest, keys = handles.rest(obj).astype(float), obj.data.shape_keys.key_blocks
    for key, axis in zip(keys[-2:], ((1, 0, 0), (0, 1, 0)), strict=True):  # as an artist mends them
        key.data.foreach_set("co", bent_tubes.posed(rest, [(4.8, axis, 150.0)], 0.6).astype(np.float32).ravel())
    obj.data.update_tag()
    handles.update()
    found = part("posing.bridge.scene_input").gather(obj)
    assert found.bends == "Bends as 2 kept poses do"
    assert found.stiffness[RINGS[8]].mean() < 12.0 and found.stiffness[RINGS[[1, 2, 14, 15]]].min() > 25.0
