# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists do to shape keys while in-between keys or a bake stand for their mix."""

import bpy
import numpy as np
import pytest
from support import bent_limb, installed, libraries, meshes, steps
from support import mixed_limbs as limbs


def full_copy_of(obj):
    for each in bpy.context.selected_objects:
        each.select_set(False)
    meshes.activate(obj)
    obj.select_set(True)
    bpy.ops.object.duplicate(linked=False)
    return bpy.context.object


def test_in_betweens_are_those_of_all_objects_with_the_mesh(status):
    obj = limbs.bending()
    limbs.bake(obj)
    made = limbs.in_betweens_of(obj)
    twin = meshes.new_object("Twin", obj.data)
    twin.meanvalue.mix.is_on = True
    limbs.set_value(twin, "Bend", 0.5)
    assert "Remove In-Betweens" in status(twin)[0] and limbs.MIX not in limbs.keys_of(obj)
    twin.meanvalue.mix.is_on = False
    limbs.bake(twin)
    assert len(limbs.keys_of(obj)) == 2 + len(made)
    steps.run(twin, "bake_mix", remove=True)
    assert len(limbs.keys_of(obj)) == 2
    for each in (twin, obj):
        meshes.activate(each)
        with pytest.raises(RuntimeError, match="no in-between keys"):
            bpy.ops.meanvalue.bake_mix(remove=True)


def test_in_betweens_of_a_full_copy_follow_its_own_sliders():
    obj = limbs.bending()
    limbs.bake(obj)
    copy = full_copy_of(obj)
    assert copy.data != obj.data
    limbs.set_value(copy, "Bend", 0.5)
    limbs.set_value(obj, "Bend", 0.0)
    assert limbs.miss(copy, bent_limb.bent(limbs.rest(), 70.0)) <= 0.25 * limbs.linear_miss(140.0, 0.5)
    np.testing.assert_allclose(limbs.shown(obj), limbs.rest(), atol=1e-5)


def test_in_betweens_go_on_when_a_slider_is_renamed():
    obj = limbs.bending()
    limbs.bake(obj)
    limbs.set_value(obj, "Bend", 0.5)
    before = limbs.shown(obj)
    limbs.keys_of(obj)["Bend"].name = 'El"bow\\'
    limbs.set_value(obj, 'El"bow\\', 0.0)
    limbs.set_value(obj, 'El"bow\\', 0.5)
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-5)


def test_renamed_in_betweens_are_still_known():
    obj = limbs.bending()
    limbs.bake(obj)
    made = limbs.in_betweens_of(obj)
    limbs.keys_of(obj)[made[0]].name = "Elbow half"
    limbs.bake(obj)
    assert limbs.in_betweens_of(obj) == made
    assert bpy.ops.meanvalue.bake_mix(remove=True) == {"FINISHED"}
    assert len(limbs.keys_of(obj)) == 2


def test_a_slider_that_in_betweens_need_is_deleted():
    obj = limbs.limb(Bend=bent_limb.bent(limbs.rest(), 110.0), Stretch=limbs.rest() * (1.1, 1.0, 1.0))
    limbs.bake(obj, 1.0)
    limbs.set_value(obj, "Bend", 0.5)
    obj.shape_key_remove(limbs.keys_of(obj)["Bend"])
    limbs.keys_of(obj)["Stretch"].mute = True
    assert bpy.ops.meanvalue.bake_mix(remove=True) == {"FINISHED"}
    assert [key.name for key in limbs.keys_of(obj)] == ["Basis", "Stretch"]


def test_keys_that_need_none_any_more_lose_their_in_betweens():
    obj = limbs.bending()
    limbs.bake(obj)
    straight = (limbs.rest() * (1.05, 1.0, 1.0)).astype(np.float32)
    limbs.keys_of(obj)["Bend"].data.foreach_set("co", straight.ravel())
    obj.data.update_tag()
    limbs.bake(obj, 5.0)
    assert [key.name for key in limbs.keys_of(obj)] == ["Basis", "Bend"]


def test_all_keys_deleted_while_in_betweens_are_there():
    obj = limbs.bending()
    limbs.bake(obj)
    obj.shape_key_clear()
    steps.add_key(obj, "Bend", bent_limb.bent(limbs.rest(), 140.0))
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Bend", 0.5)
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 70.0)) <= 0.25 * limbs.linear_miss(140.0, 0.5)


@pytest.mark.parametrize("low, high", [(-1.0, 1.0), (0.0, 2.0)])
def test_in_betweens_are_within_the_tolerance_over_the_whole_range_and_need_no_addon(low, high):
    obj = limbs.bending(60.0)
    limbs.keys_of(obj)["Bend"].slider_min, limbs.keys_of(obj)["Bend"].slider_max = low, high
    obj.meanvalue.mix.is_on = True
    values = [*np.linspace(low, high, 5), *np.random.default_rng(11).uniform(low, high, 8)]
    shapes = []
    for value in values:
        limbs.set_value(obj, "Bend", value)
        shapes.append(limbs.shown(obj))
        assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 60.0 * value)) <= 0.02 * limbs.DIAGONAL
    limbs.bake(obj)
    assert not obj.meanvalue.mix.is_on and limbs.MIX not in limbs.keys_of(obj)
    assert 1 <= len(limbs.in_betweens_of(obj)) <= 6
    installed.disable()
    for value, shape in zip(values, shapes, strict=True):
        limbs.set_value(obj, "Bend", value)
        assert np.linalg.norm(limbs.shown(obj) - shape, axis=1).max() <= 0.002 * limbs.DIAGONAL


@pytest.fixture
def playing(tmp_path):
    """An animated mix in shape keys, frame by frame."""
    obj = limbs.animated(tmp_path)
    assert bpy.ops.meanvalue.bake(target="SHAPE_KEYS", tolerance_share=0) == {"FINISHED"}
    bpy.context.scene.frame_set(6)
    return obj


def test_mixing_does_not_add_to_a_bake_that_plays(playing, status):
    before = limbs.shown(playing)
    playing.meanvalue.mix.is_on = True
    bpy.context.view_layer.update()
    np.testing.assert_allclose(limbs.shown(playing), before, atol=1e-4)
    assert "Remove Bake" in status(playing)[0]


def test_in_betweens_do_not_add_to_a_bake_that_plays(playing):
    with steps.refused("Remove Bake", unchanged=playing):
        bpy.ops.meanvalue.bake_mix()


def test_a_bake_does_not_add_to_in_betweens(tmp_path):
    obj = limbs.bending()
    limbs.animate(obj)
    limbs.bake(obj)
    before = {}
    for frame in (3, 6):
        bpy.context.scene.frame_set(frame)
        before[frame] = limbs.shown(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mix.blend"))
    obj = bpy.data.objects["Limb"]
    meshes.activate(obj)
    obj.meanvalue.mix.is_on = True
    assert bpy.ops.meanvalue.bake(target="SHAPE_KEYS", tolerance_share=0) == {"FINISHED"}
    for frame, shape in before.items():
        bpy.context.scene.frame_set(frame)
        assert np.abs(limbs.shown(obj) - shape).max() <= 0.005 * limbs.DIAGONAL
    assert bpy.ops.meanvalue.unbake() == {"FINISHED"}
    bpy.context.scene.frame_set(1)
    for frame, shape in before.items():
        bpy.context.scene.frame_set(frame)
        assert np.abs(limbs.shown(obj) - shape).max() <= 0.005 * limbs.DIAGONAL


def test_a_new_slider_beside_in_betweens_is_told_to_be_baked(capfd):
    other = limbs.bending(60.0)
    other.name = "Source"
    limbs.keys_of(other)["Bend"].value = 1.0
    obj = limbs.bending()
    limbs.bake(obj)
    made = limbs.in_betweens_of(obj)
    assert bpy.ops.meanvalue.morph(source="Source") == {'FINISHED'}
    assert "Bake Mix" in capfd.readouterr().out
    assert not obj.meanvalue.mix.is_on
    assert limbs.in_betweens_of(obj) == made


def test_undo_of_bake_mix_brings_live_mixing_back():
    obj = limbs.mixing()
    bpy.ops.ed.undo_push(message="before")
    before = limbs.shown(obj)
    limbs.bake(obj)
    bpy.ops.ed.undo_push(message="baked")
    made = limbs.in_betweens_of(obj)
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Limb"]
    assert obj.meanvalue.mix.is_on and limbs.in_betweens_of(obj) == []
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-4)
    bpy.ops.ed.redo()
    obj = bpy.data.objects["Limb"]
    assert not obj.meanvalue.mix.is_on and limbs.in_betweens_of(obj) == made


def test_in_betweens_are_saved_and_appended(tmp_path):
    obj = limbs.bending()
    limbs.bake(obj)
    limbs.set_value(obj, "Bend", 0.5)
    before, made = limbs.shown(obj), limbs.in_betweens_of(obj)
    path = str(tmp_path / "baked.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    (obj,) = libraries.load(path, "objects", ["Limb"])
    limbs.set_value(obj, "Bend", 0.0)
    limbs.set_value(obj, "Bend", 0.5)
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-4)
    assert limbs.in_betweens_of(obj) == made
    steps.run(obj, "bake_mix", remove=True)
    assert [key.name for key in limbs.keys_of(obj)] == ["Basis", "Bend"]


def test_baked_anew_otherwise_and_taken_back(playing):
    """Between frames too, at one of which both bakes have a key."""
    bpy.context.scene.frame_set(7)
    before = limbs.shown(playing)
    playing.meanvalue.mix.is_on = True
    assert bpy.ops.meanvalue.bake(target='SHAPE_KEYS', tolerance_share=0, samples=2) == {'FINISHED'}
    bpy.context.scene.frame_set(7)
    np.testing.assert_allclose(limbs.shown(playing), before, atol=1e-4)
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    bpy.context.view_layer.update()
    assert playing.meanvalue.mix.is_on
    np.testing.assert_allclose(limbs.shown(playing), before, atol=1e-3)
    assert [key.name for key in limbs.keys_of(playing)] == ["Basis", "Bend", limbs.MIX]
