# SPDX-License-Identifier: GPL-3.0-or-later
"""Bend At: limbs bend at the joints of their rig, or as kept poses do."""

import bpy
import numpy as np
import pytest
from support import armatures, baking, bent_tubes, handles, meshes, rigs, steps
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


@pytest.mark.parametrize("change", ["deform", "parent", "place", "turn"])
def test_it_notices_that_bones_were_edited(change):
    obj, armature = rigs.arm()
    rigs.pin(obj, "Bottom", rigs.BOTTOM)
    obj.parent = armature.parent = root = bpy.data.objects.new("Root", None)
    bpy.context.collection.objects.link(root)
    handles.update()
    model = part("posing.bridge.scene_input").model(obj)
    model.read(obj)
    assert model.is_read(obj)
    meshes.activate(armature)
    if change == "deform":
        armature.data.bones["Lower"].use_deform = False
    elif change == "turn":
        root.rotation_euler.z += 1.0
        handles.update()
        assert model.is_read(obj)
        obj.rotation_euler.z += 1.0
    else:
        bpy.ops.object.mode_set(mode='EDIT')
        bone = armature.data.edit_bones["Lower"]
        bone.parent, bone.head = (None, bone.head) if change == "parent" else (bone.parent, (0.0, 1.0, 4.0))
        bpy.ops.object.mode_set(mode='OBJECT')
    handles.update()
    assert not model.is_read(obj)


def test_joints_are_tinted_in_place_of_the_region():
    obj, _armature = rigs.arm()
    rigs.pin(obj, "Bottom", rigs.BOTTOM)
    steps.add_group(obj, "Region", range(40))
    obj.meanvalue.roi_group = "Region"
    look = part("posing.ui.overlay").look_of
    of_region = look(obj).tinted
    obj.meanvalue.roi_group, obj.meanvalue.show_joints = "", True
    handles.update()
    found = look(obj)
    height = found.positions[found.tinted, 2]
    assert np.abs(height - rigs.ELBOW).max() < rigs.SHARE and found.freedom.max() == 1.0
    obj.meanvalue.roi_group, obj.meanvalue.show_joints = "Region", False
    handles.update()
    assert np.array_equal(look(obj).tinted, of_region)


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


#: Bones of the upper and the lower half of a limb and of what hangs on it, by well-known names.
LEGS = {
    "MakeHuman": ("upperleg01.L", "lowerleg01.L", "foot.L"),
    "Rigify": ("DEF-thigh.L", "DEF-shin.L", "DEF-foot.L"),
    "Rigify horse": ("thigh.L", "lower_leg.L", "hind_foot.L"),
    "Mixamo": ("mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot"),
    "VRM": ("J_Bip_L_UpperLeg", "J_Bip_L_LowerLeg", "J_Bip_L_Foot"),
}
ARMS = {
    "MakeHuman": ("upperarm01.L", "lowerarm01.L", "wrist.L"),
    "Rigify": ("DEF-upper_arm.L", "DEF-forearm.L", "DEF-hand.L"),
    "Rigify horse": ("upper_arm.L", "forearm.L", "forefoot.L"),
    "Mixamo": ("mixamorig:LeftArm", "mixamorig:LeftForeArm", "mixamorig:LeftHand"),
    "VRM": ("J_Bip_L_UpperArm", "J_Bip_L_LowerArm", "J_Bip_L_Hand"),
}


def limb(bones, foot=None):
    """(mesh object, control of its lower end): a straight limb along z, pinned at its top; the figure looks to -y.

    foot: the name of a bone that tells so, where none of the limb's does.
    """
    upper, lower, end = bones
    joint, bottom, toe = (0.0, 0.0, rigs.ELBOW), (0.0, 0.0, 0.6), (0.0, -1.0, 0.3)
    obj = meshes.tube(rigs.RINGS, rigs.SEGMENTS, "Limb")
    armature = armatures.make(
        **{upper: ((0.0, 0.0, rigs.LENGTH), joint), lower: (joint, bottom, upper)},
        **{end: (bottom, (0.0, 0.0, 0.0) if foot else toe, lower)},
        **({foot: (bottom, toe)} if foot else {}),
    )
    meshes.activate(obj)
    height = np.array([vertex.co.z for vertex in obj.data.vertices])
    above, tips = np.clip((height - 4.2) / 1.2, 0.0, 1.0), np.clip((0.9 - height) / 0.6, 0.0, 1.0)
    for bone, weights in ((upper, above), (lower, 1.0 - above - tips), (end, tips)):
        steps.add_weights(obj, bone, weights)
    obj.modifiers.new("Armature", 'ARMATURE').object = armature
    handles.update()
    rigs.pin(obj, "Hip", rigs.TOP)
    return obj, rigs.handle(obj, "Foot", rigs.BOTTOM)


@pytest.mark.parametrize("is_arm", [False, True])
@pytest.mark.parametrize("name", LEGS)
def test_a_straight_knee_goes_forward_and_an_elbow_back(name, is_arm, tmp_path):
    """In a drag, settled, in a bake, and from rest in the file that is loaded again."""
    obj, control = limb((ARMS if is_arm else LEGS)[name], LEGS[name][2] if is_arm else None)

    def require_bent(shape):
        x, y, _z = shape[RINGS[7:10]].reshape(-1, 3).mean(axis=0)
        assert (y if is_arm else -y) > 2.0 and abs(x) < 0.2

    control.keyframe_insert("location", frame=1)
    for _ in range(8):
        handles.move(control, (0.0, 0.0, 0.4))
    require_bent(handles.shown(obj))
    steps.run(obj, "solve")
    settled = handles.shown(obj)
    require_bent(settled)
    control.keyframe_insert("location", frame=5)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 5
    path = tmp_path / "limb.pc2"
    baking.bake(path=str(path))
    require_bent(baking.rows(path)[-1])
    bpy.ops.meanvalue.unbake()
    obj.meanvalue.live = False
    baking.save(tmp_path)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.context.scene.frame_set(5)
    obj = bpy.data.objects["Limb"]
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'} and bpy.ops.meanvalue.solve() == {'FINISHED'}
    require_bent(handles.shown(obj))
    assert np.abs(handles.shown(obj) - settled).max() < 1e-3 * rigs.size(obj)


def test_a_hand_beyond_its_arm_stops_there_and_the_panel_says_so(tmp_path):
    obj, control = limb(ARMS["Rigify"], "DEF-foot.L")

    def is_told():
        return "'Foot' is out of reach" in part("posing.ui.panel")._status(obj)[0]

    def length():
        rings = handles.shown(obj)[RINGS[[15, 0]]].mean(axis=1)
        return np.linalg.norm(rings[0] - rings[1]) / rigs.LENGTH

    control.keyframe_insert("location", frame=1)
    handles.move(control, (0.0, -2.0, -0.3))
    assert not is_told() and handles.follows(obj, (0.0, -2.0, -0.3), rigs.BOTTOM)
    bpy.ops.meanvalue.grab(handle="Foot", offset=(0.0, 2.0, -2.7))  # the control stays at the hand
    handles.update()
    assert not is_told() and 1.0 < length() < 1.1 and handles.follows(obj, control.location, rigs.BOTTOM)
    handles.move(control, (0.0, 0.0, -3.0))
    assert is_told() and 1.0 < length() < 1.1
    drawn = handles.shown(obj)
    control.keyframe_insert("location", frame=3)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 3
    baking.bake(path=str(tmp_path / "arm.pc2"))
    assert np.abs(baking.rows(tmp_path / "arm.pc2")[-1] - drawn).max() < 1e-3 * rigs.size(obj)
    bpy.ops.meanvalue.unbake()
    obj.meanvalue.stretch = obj.meanvalue.live = True
    bpy.context.scene.frame_set(3)
    handles.update()
    assert not is_told() and length() > 1.2


def test_what_hangs_on_a_pressed_limb_goes_along_as_bones_do():
    obj, _control = limb(LEGS["MakeHuman"])
    obj.meanvalue.handles["Foot"].is_enabled = False
    rest, pressed, below = handles.rest(obj), int(RINGS[5][0]), RINGS[:6].ravel()
    bpy.ops.meanvalue.grab(vertex=pressed, size=2.5 / (0.85 * rigs.size(obj)), offset=(0.0, -2.0, 0.4))
    shown = handles.shown(obj)
    assert (rest - shown)[rigs.BOTTOM, 1].min() > 1.5 and np.abs(shown - rest)[rigs.TOP].max() == 0.0
    across = [np.linalg.norm(shape[below] - shape[below[0]], axis=1) for shape in (shown, rest)]
    assert np.abs(across[0] - across[1]).max() < 0.02 * rigs.LENGTH


def test_a_press_whose_surroundings_pass_a_knee_reaches_up_to_the_body():
    obj, _control = limb(LEGS["MakeHuman"])
    up_to_body, sole = part("posing.bridge.limbs").up_to_body, rigs.BOTTOM[0]
    meshes.activate(obj)
    steps.edit_mesh(obj, lambda mesh: mesh.verts[:][sole][mesh.verts.layers.deform.verify()].__setitem__(99, 0.1))
    assert up_to_body(obj, sole, 4.0) == 4.0 and up_to_body(obj, rigs.TOP[0], 5.5) == 5.5
    assert rigs.LENGTH < up_to_body(obj, sole, 5.5) < 1.2 * rigs.LENGTH
    assert [part("posing.bridge.limbs").least(obj, sole, each) > 4.0 for each in (0.3, 1.5)] == [False, True]
