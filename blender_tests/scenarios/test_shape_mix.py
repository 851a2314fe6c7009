# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that turn: mixed live, baked to in-between keys with drivers."""

import bpy
import numpy as np
import pytest
from support import armatures, bent_limb, meshes, steps
from support import mixed_limbs as limbs
from support.interface import interface, is_settled
from support.snapshot import assert_same, snapshot


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_a_mixed_bend_follows_the_arc(share):
    obj = limbs.mixing(value=share)
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), share * 140.0)) <= 0.25 * limbs.linear_miss(140.0, share)


def test_a_dragged_slider_settles_to_what_its_value_alone_says():
    obj = limbs.mixing(value=0.52)
    expected = limbs.shown(obj)
    limbs.set_value(obj, "Bend", 0.2)
    with interface() as timers:
        for value in np.linspace(0.24, 0.52, 8):  # no time passes: it is dragged
            limbs.set_value(obj, "Bend", value)
        assert np.abs(limbs.shown(obj) - expected).max() <= 2e-3 * limbs.DIAGONAL
        timers.run(0.1)
        assert is_settled(obj)
        np.testing.assert_array_equal(limbs.shown(obj), expected)


def test_a_soup_stays_closed_where_its_keys_have_it_closed():
    whole, faces = bent_limb.limb()
    corners = np.concatenate(faces)
    obj = meshes.make_object(*meshes.split(whole, faces), "Soup")
    key = steps.add_key(obj, "Bend", bent_limb.bent(whole, 140.0)[corners])
    obj.meanvalue.mix.is_on = True
    for value in (0.5, 1.0):
        limbs.set_value(obj, "Bend", value)
        assert meshes.gap(obj) == 0.0
    limbs.bake(obj)
    obj.meanvalue.mix.is_on = False
    limbs.set_value(obj, "Bend", 0.5)
    assert meshes.gap(obj) < 1e-5 and np.abs(limbs.shown(obj) - bent_limb.bent(whole, 70.0)[corners]).max() < 0.3
    key.data[0].co.z += 1.0  # opens the seam there
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Bend", 0.4)
    assert meshes.gap(obj) > 0.1


def test_off_it_goes_in_straight_lines_again():
    obj = limbs.bending()
    before = snapshot(obj)
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Bend", 0.5)
    assert "Rotation-Aware Mix" in obj.data.shape_keys.key_blocks
    obj.meanvalue.mix.is_on = False
    limbs.set_value(obj, "Bend", 0.0)
    assert_same(before, snapshot(obj))


def test_live_posing_and_mixing_take_turns():
    obj = limbs.bending()
    obj.meanvalue.mix.is_on = True
    obj.meanvalue.live = True
    assert not obj.meanvalue.mix.is_on and "Rotation-Aware Mix" not in obj.data.shape_keys.key_blocks
    obj.meanvalue.mix.is_on = True
    assert not obj.meanvalue.live


def test_an_edited_key_is_mixed_as_it_is_now():
    obj = limbs.mixing()
    key = obj.data.shape_keys.key_blocks["Bend"]
    key.data.foreach_set("co", bent_limb.bent(limbs.rest(), -90.0).astype(np.float32).ravel())
    obj.data.update_tag()
    limbs.set_value(obj, "Bend", 0.501)
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), -45.1)) <= 0.25 * limbs.linear_miss(-90.0, 0.5)


def masked_and_bending():
    """A key that is thicker in the last third alone, by a group with a soft edge, beside one that bends all."""
    obj = limbs.limb(Thick=limbs.rest() * (1.0, 1.5, 1.5), Bend=bent_limb.bent(limbs.rest(), 110.0))
    steps.add_weights(obj, "Tail", np.clip((limbs.rest()[:, 0] - 3.5) / 0.5, 0.0, 1.0))
    obj.data.shape_keys.key_blocks["Thick"].vertex_group = "Tail"
    return obj


def test_a_masked_slider_does_not_make_the_mesh_jump():
    obj = masked_and_bending()
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Thick", 0.6)
    shapes = []
    for bend in np.linspace(0.0, 1.0, 21):
        limbs.set_value(obj, "Bend", bend)
        shapes.append(limbs.shown(obj))
    assert np.linalg.norm(np.diff(shapes, axis=0), axis=2).max() <= 0.1 * limbs.DIAGONAL
    limbs.set_value(obj, "Thick", 0.0)
    np.testing.assert_allclose(limbs.shown(obj), bent_limb.bent(limbs.rest(), 110.0), atol=1e-5)


def test_in_betweens_taken_back_leave_nothing():
    obj = limbs.bending()
    before = snapshot(obj, without=("settings",))
    limbs.bake(obj)
    assert bpy.ops.meanvalue.bake_mix(remove=True) == {'FINISHED'}
    assert_same(before, snapshot(obj, without=("settings",)))
    animation = obj.data.shape_keys.animation_data
    assert animation is None or len(animation.drivers) == 0


@pytest.mark.parametrize(
    "spoil, texts",
    [
        (lambda obj: obj.shape_key_clear(), ("no shape keys",)),
        (lambda obj: setattr(obj.data.shape_keys, "use_relative", False), ("absolute",)),
        (lambda obj: setattr(obj.data.shape_keys.key_blocks["Bend"], "mute", True), ("muted",)),
        (lambda obj: relate_to_another(obj), ("'Other'", "relative to another key", "'Basis'")),
        (lambda obj: setattr(obj.data.shape_keys.key_blocks["Bend"], "vertex_group", "Gone"), ("vertex group",)),
        (lambda obj: put_nan(obj), ("'Bend'", "not numbers")),
    ],
)
def test_refused(spoil, texts):
    obj = limbs.bending()
    obj.vertex_groups.new(name="Gone")
    spoil(obj)
    if obj.data.shape_keys:
        obj.vertex_groups.clear()
    with steps.refused(*texts, unchanged=obj):
        bpy.ops.meanvalue.bake_mix()


def relate_to_another(obj):
    key = obj.shape_key_add(name="Other", from_mix=False)
    key.relative_key = obj.data.shape_keys.key_blocks["Bend"]


def put_nan(obj):
    obj.data.shape_keys.key_blocks["Bend"].data[3].co.x = float("nan")


def test_undo_and_reload_keep_the_mix(tmp_path):
    obj = limbs.mixing()
    before = limbs.shown(obj)
    obj = steps.reopened(obj, tmp_path / "mix.blend")
    assert obj.meanvalue.mix.is_on
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-5)
    limbs.set_value(obj, "Bend", 0.25)
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 35.0)) <= 0.25 * limbs.linear_miss(140.0, 0.25)


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
def test_animated_sliders_are_baked_frame_by_frame(tmp_path, target):
    obj = limbs.animated(tmp_path)
    bpy.context.scene.frame_set(1)
    before = snapshot(obj, without=("settings",))
    live = {}
    for frame in (1, 4, 9, 12):
        bpy.context.scene.frame_set(frame)
        live[frame] = limbs.shown(obj)
    bpy.context.scene.frame_set(1)
    assert bpy.ops.meanvalue.bake(target=target, tolerance_share=0) == {'FINISHED'}
    assert not obj.meanvalue.mix.is_on
    for frame, shape in live.items():
        bpy.context.scene.frame_set(frame)
        assert np.abs(limbs.shown(obj) - shape).max() <= 1e-3 * limbs.DIAGONAL
    assert bpy.ops.meanvalue.bake(target=target, tolerance_share=0) == {'FINISHED'}  # nothing has changed
    bpy.context.scene.frame_set(1)
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert obj.meanvalue.mix.is_on
    assert_same(before, snapshot(obj, without=("settings",)))


# -- posed by an armature ----------------------------------------------------------------------------------------------


TURN = np.radians(70.0)
SHIFT = (2.0, -1.0, 3.0)


@pytest.fixture
def rigged():
    """(object, pose bone): half of the limb follows the bone."""
    obj = limbs.bending()
    rig = armatures.make(Bone=((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    meshes.activate(obj)
    group = obj.vertex_groups.new(name="Bone")
    group.add(np.flatnonzero(follows()).tolist(), 1.0, 'REPLACE')
    modifier = obj.modifiers.new("Armature", 'ARMATURE')
    modifier.object = rig
    return obj, rig.pose.bones["Bone"]


def follows():
    """(n,) bool."""
    longest = np.ptp(limbs.rest(), axis=0).argmax()
    return limbs.rest()[:, longest] > limbs.rest()[:, longest].mean()


def pose(bone):
    bone.rotation_mode = 'XYZ'
    bone.rotation_euler = (0.0, TURN, 0.3)
    bone.location = SHIFT
    bpy.context.view_layer.update()


def posed(bone, shape):
    """(n, 3): what the armature makes of the shape that it is given."""
    matrix = np.array(bone.matrix @ bone.bone.matrix_local.inverted())
    return np.where(follows()[:, None], shape @ matrix[:3, :3].T + matrix[:3, 3], shape)


@pytest.mark.parametrize("is_baked", [False, True], ids=["live", "baked"])
def test_an_armature_poses_the_mixed_shape(rigged, is_baked):
    obj, bone = rigged
    obj.meanvalue.mix.is_on = True
    if is_baked:
        limbs.bake(obj)
    limbs.set_value(obj, "Bend", 0.5)
    mixed = limbs.shown(obj)
    pose(bone)
    np.testing.assert_allclose(limbs.shown(obj), posed(bone, mixed), atol=1e-5 * limbs.DIAGONAL)
    assert np.abs(limbs.shown(obj) - mixed).max() > 0.1 * limbs.DIAGONAL
    limbs.set_value(obj, "Bend", 0.0)
    limbs.set_value(obj, "Bend", 0.5)  # mixed while it is posed
    np.testing.assert_allclose(limbs.shown(obj), posed(bone, mixed), atol=1e-4 * limbs.DIAGONAL)
