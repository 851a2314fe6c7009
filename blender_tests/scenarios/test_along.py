# SPDX-License-Identifier: GPL-3.0-or-later
"""What is worn goes along: a sleeve and a button on a tube, in objects of their own."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import armatures, baking, handles, meshes, steps
from support.handles import rest, shown, update

SAME, FAR = Matrix(), Matrix.Translation((30.0, -9.0, 4.0)) @ Matrix.Scale(0.01, 4)
MIRRORED = Matrix.Rotation(0.7, 4, (1, 2, 3)) @ Matrix.Diagonal((-2.0, 0.5, 1.5, 1.0))


def moved(points, matrix):
    return points @ np.array(matrix, np.float64)[:3, :3].T + np.array(matrix)[:3, 3]


def add(obj, vertices, faces, name, place):
    """A child of `obj` with vertices in its space, whose own space is another one."""
    worn = meshes.make_object(moved(vertices, np.linalg.inv(place)).tolist(), faces, name)
    worn.parent, worn.matrix_basis = obj, place
    return worn


def dressed(place=SAME, is_held=True):
    """(tube, sleeve, button, the control of a handle that is moved or None)."""
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS)
    obj.matrix_world = Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Diagonal((1.0, -1.5, 1.0, 1.0))
    height, angle = (each.ravel() for each in np.mgrid[3.0:8.0:9j, 0.0:6.0:12j])
    around = np.stack([1.4 * np.cos(angle), 1.4 * np.sin(angle), height], axis=1)
    sleeve = add(obj, around, meshes.grid_faces(12, 9), "Sleeve", place)
    button = add(obj, 0.1 * np.eye(4)[:, :3] + [1.5, 0, 6], [(0, 1, 3), (1, 2, 3)], "Button", place)
    meshes.activate(obj)
    if not is_held:
        return obj, sleeve, button, None
    steps.add_handle(obj, "Bottom", handles.BOTTOM, pin=True)
    control = steps.add_handle(obj, "Top", handles.TOP)
    update()
    handles.move(control, (3.0, 0.0, -1.0))
    return obj, sleeve, button, control


def test_it_goes_along_wherever_its_own_space_is():
    found = []
    for place in (SAME, MIRRORED, FAR):
        obj, *others, _control = dressed(place)
        found.append([moved(points(each), each.matrix_world) for each in others for points in (rest, shown)])
        handles.assert_reset_puts_at_rest(obj)
        assert all(np.array_equal(shown(each), rest(each)) for each in others)
        bpy.data.objects.remove(obj)
    for sleeve, bent, button, carried in found:
        assert np.abs(bent - sleeve).max() > 1.0 and np.abs(carried - button).max(axis=1).min() > 0.5
        assert max(np.abs(bent - found[0][1]).max(), np.abs(carried - found[0][3]).max()) < 1e-3


def test_the_body_takes_a_suit_along_and_no_suit_the_body(part):
    rig = armatures.make(Upper=((0.0, 0.0, 10.0), (0.0, 0.0, 5.0)), Lower=((0.0, 0.0, 5.0), (0.0, 0.0, 0.0)))
    body, suit = meshes.tube(handles.RINGS, handles.SEGMENTS, "Body"), meshes.tube(4, handles.SEGMENTS, "Suit")
    suit.scale = (1.1, 1.1, 9.0)  # larger than the body, but of fewer bones
    for obj, bones in ((body, ("Upper", "Lower")), (suit, ("Upper",))):
        steps.add_weights(obj, bones[0], np.ones(len(obj.data.vertices)))
        obj.vertex_groups.new(name=bones[-1]) if len(bones) > 1 else None
        obj.modifiers.new("Armature", 'ARMATURE').object = rig
    update()
    worn = part("scene.worn")
    assert [worn.body_of(*each) for each in ((suit, suit), (suit, None), (body, suit))] == [body, body, None]
    for obj, other, is_taken in ((suit, body, False), (body, suit, True)):
        worn.find(obj)
        assert [(line.object, line.is_taken) for line in obj.meanvalue.along] == [(other, is_taken)]
        obj.meanvalue.along.clear()
        worn.forget()


def test_what_follows_by_itself_and_what_must_not_be_written_is_left_alone(part):
    obj, sleeve, _button, control = dressed()
    words = {"Surface": "Surface Deform", "Hung": "Vertex", "Shared": "shares", "Flat": "scaled", "Own": "of its own"}
    words["Cage"] = "deforms 'Tube'"
    alone = {name: add(obj, np.add(np.eye(3), [1, 0, 2]), [(0, 1, 2)], name, SAME) for name in words}
    alone["Surface"].modifiers.new("Follow", 'SURFACE_DEFORM')
    obj.modifiers.new("Bound", 'MESH_DEFORM').object = alone["Cage"]
    alone["Hung"].parent_type = 'VERTEX'
    meshes.new_object("Twin", alone["Shared"].data)
    alone["Flat"].scale.z = 0.0
    alone["Own"].meanvalue.handles.add().name = "Hand"
    steps.run(obj, "find_along")
    handles.move(control, (0.5, 0.0, 0.0))
    told = part("scene.along").problems(obj)
    assert all(any(f"'{name}'" in text and words[name] in text for text in told) for name in words), told
    assert not any(each.data.shape_keys for each in alone.values()) and len(part("scene.worn").taken(obj)) == 2
    sleeve.data.shape_keys.use_relative = False
    assert "'Sleeve' is left alone. The shape keys are absolute" in part("scene.along").problems(obj)[0]


def test_one_slider_moves_all_and_what_is_renamed_deleted_and_opened_again_goes_on(tmp_path):
    obj, sleeve, button, control = dressed()
    bent = shown(sleeve)
    steps.run(obj, "keep_pose", name="Bow")
    update()
    assert np.array_equal(steps.key_positions(sleeve, "Bow"), bent) and np.array_equal(shown(sleeve), rest(sleeve))
    obj.data.shape_keys.key_blocks["Bow"].name, sleeve.data.shape_keys.key_blocks["Bow"].name = "Nod", "Mine"
    sleeve.name = "Shirt"
    meshes.new_object("A Copy", obj.data.copy()).meanvalue.along.add().object = sleeve
    bpy.data.objects.remove(button)
    handles.move(control, (0.0, 2.0, 0.0))
    obj = steps.reopened(obj, tmp_path / "dressed.blend")
    sleeve, kept = bpy.data.objects["Shirt"], obj.data.shape_keys.key_blocks["Nod"]
    for kept.value, kept.mute in ((0.5, False), (1.0, True)):
        update()
        wanted = shown(sleeve) + kept.value * (not kept.mute) * (bent - rest(sleeve))
        assert np.abs(meshes.seen(sleeve) - wanted).max() < 1e-5
    before = shown(sleeve)
    handles.move(obj.meanvalue.handles["Top"].control, (0.0, -2.0, 0.0))
    assert np.abs(shown(sleeve) - before).max() > 0.5 and len(obj.meanvalue.along) == 1
    steps.run(obj, "finish", keep='NOTHING')
    assert [key.name for key in sleeve.data.shape_keys.key_blocks] == ["Basis", "Mine"]


def test_apply_and_finish_do_it_for_all_and_a_grab_that_is_given_up_leaves_nothing(part):
    obj, sleeve, _button, control = dressed()
    bent = shown(sleeve)
    steps.run(obj, "apply_pose")
    update()
    assert np.abs(rest(sleeve) - bent).max() < 1e-5 and np.abs(meshes.seen(sleeve) - bent).max() < 1e-3
    handles.move(control, (0.0, 1.0, 0.0))
    moved_on = meshes.seen(sleeve)
    steps.run(obj, "finish", keep='SHAPE_KEY')
    update()
    assert np.abs(meshes.seen(sleeve) - moved_on).max() < 1e-3 and not obj.meanvalue.along
    obj, *others, _control = dressed(is_held=False)
    grip = part("posing.bridge.grip").Grip(obj, handles.TOP[0], 0.5)
    grip.move(obj, (1.0, 0.0, 0.0))
    update()
    assert all(each.data.shape_keys for each in (obj, *others))
    grip.take_back(obj)
    assert not obj.meanvalue.along and not any(each.data.shape_keys for each in (obj, *others))


def test_edits_of_its_pose_are_kept_and_unticking_takes_the_pose_back():
    obj, sleeve, button, control = dressed()
    meshes.activate(sleeve)
    sleeve.active_shape_key_index = 1
    steps.move(sleeve, [5], (0.0, 0.0, 0.7))
    update()
    bpy.ops.object.mode_set(mode='EDIT')
    handles.move(control, (0.5, 0.0, 0.0))
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    edit = steps.key_positions(sleeve, "Mean-Value Edit") - rest(sleeve)
    assert abs(edit[5, 2] - 0.7) < 1e-5 and np.abs(edit).sum() < 0.71
    for obj.meanvalue.along["Button"].is_taken in (False, True):
        update()
        assert bool(button.data.shape_keys) == obj.meanvalue.along["Button"].is_taken
    obj.shape_key_clear()
    handles.move(control, (0.5, 0.0, 0.0))
    assert np.abs(meshes.seen(button) - rest(button)).max() > 0.5


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
def test_a_bake_plays_in_all_and_is_taken_back(target, tmp_path):
    obj, *others, control = dressed()
    baking.key_control(control, 4)
    baking.save(tmp_path)
    live = [baking.played(each, range(1, 5)) for each in others]
    if target == 'POINT_CACHE':
        obj.name, others[0].name = "One.L", "One_l"
        with steps.refused("'One.L' and 'One_l' would be baked to one file"):
            steps.run(obj, "bake", target=target)
        others[0].name = "Other"
    steps.run(obj, "bake", target=target)
    assert all(np.abs(baking.played(each, range(1, 5)) - live.pop(0)).max() < 0.02 for each in others)
    own = meshes.new_object("Own", others[0].data.copy())
    own.meanvalue.handles.add().name, own.meanvalue.baked.target = "Hand", target
    obj.meanvalue.along.add().object = own
    steps.run(obj, "unbake")
    update()
    assert own.meanvalue.baked.target == target
    for each in others:
        assert [key.name for key in each.data.shape_keys.key_blocks] == ["Basis", handles.RESULT]
        assert not each.modifiers and np.abs(meshes.seen(each) - shown(each)).max() < 1e-5


def test_clothes_get_weights_of_one_armature_and_are_baked_again():
    obj, *others, control = dressed()
    baking.key_control(control)
    for _ in range(2):
        assert bpy.ops.meanvalue.bake('EXEC_DEFAULT', True, target='ARMATURE', bones=4) == {'FINISHED'}
    assert {each.modifiers[0].object for each in others} == {obj.meanvalue.baked.rig}
