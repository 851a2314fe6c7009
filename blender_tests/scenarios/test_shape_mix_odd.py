# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists do to shape keys while these are mixed, and what must not happen then."""

import bpy
import numpy as np
import pytest
from support import bent_limb, libraries, meshes, steps
from support import mixed_limbs as limbs
from support.snapshot import assert_same, snapshot


def remove_last(bm):
    bm.verts.ensure_lookup_table()
    bm.verts.remove(bm.verts[-1])


def test_the_key_that_was_deleted_is_made_again():
    obj = limbs.mixing()
    before = limbs.shown(obj)
    obj.shape_key_remove(limbs.keys_of(obj)[limbs.MIX])
    bpy.context.view_layer.update()
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-5)


def test_mixing_goes_on_when_another_object_with_the_mesh_is_turned_off():
    obj = limbs.mixing()
    before = limbs.shown(obj)
    twin = meshes.duplicate(obj, linked=True)
    twin.meanvalue.mix.is_on = False
    bpy.context.view_layer.update()
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-5)


def test_renamed_while_live():
    obj = limbs.mixing()
    limbs.keys_of(obj)["Bend"].name = 'El"bow\\'
    limbs.set_value(obj, 'El"bow\\', 0.25)
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 35.0)) <= 0.25 * limbs.linear_miss(140.0, 0.25)


@pytest.mark.parametrize("value", [False, True])
def test_switched_in_edit_mode(value):
    obj = limbs.bending()
    obj.meanvalue.mix.is_on = not value
    limbs.set_value(obj, "Bend", 0.5)
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    obj.meanvalue.mix.is_on = value
    bpy.context.view_layer.update()
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.update()
    assert (limbs.MIX in limbs.keys_of(obj)) == value
    if value:
        assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 70.0)) <= 0.25 * limbs.linear_miss(140.0, 0.5)
    else:
        assert [key.name for key in limbs.keys_of(obj)] == ["Basis", "Bend"]


def test_faces_edited_while_live(status):
    obj = limbs.mixing()
    steps.edit_mesh(obj, remove_last)
    limbs.set_value(obj, "Bend", 0.4)
    assert not status(obj)[1], status(obj)


def test_absolute_while_live_is_told_and_mended(status):
    obj = limbs.mixing()
    before = limbs.shown(obj)
    obj.data.shape_keys.use_relative = False
    bpy.context.view_layer.update()
    assert status(obj)[1] and "absolute" in status(obj)[0]
    obj.data.shape_keys.use_relative = True
    bpy.context.view_layer.update()
    assert not status(obj)[1]
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-5)


def test_all_keys_deleted_while_live(status):
    obj = limbs.mixing()
    obj.shape_key_clear()
    bpy.context.view_layer.update()
    assert status(obj)[1] and "no shape keys" in status(obj)[0]


def test_muted_and_reordered_while_live():
    obj = limbs.limb(Bend=bent_limb.bent(limbs.rest(), 140.0), Twist=bent_limb.twisted(limbs.rest(), 90.0))
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Twist", 0.7)
    limbs.set_value(obj, "Bend", 0.5)
    limbs.keys_of(obj)["Twist"].mute = True
    bpy.context.view_layer.update()
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 70.0)) <= 0.25 * limbs.linear_miss(140.0, 0.5)
    meshes.activate(obj)
    limbs.keys_of(obj)["Twist"].mute = False
    bpy.context.view_layer.update()
    before = limbs.shown(obj)
    obj.active_shape_key_index = 1
    bpy.ops.object.shape_key_move(type="DOWN")
    bpy.context.view_layer.update()
    np.testing.assert_allclose(limbs.shown(obj), before, atol=1e-4)


@pytest.mark.parametrize("count", [0, 1, 2])
def test_tiny_meshes(count, status):
    obj = meshes.make_object([(float(index), 0.0, 0.0) for index in range(count)], [], "Tiny")
    obj.shape_key_add(name="Basis")
    obj.shape_key_add(name="Other", from_mix=False).value = 0.0
    before = snapshot(obj)
    with steps.refused("No in-between keys are needed" if count == 2 else "in one place", unchanged=obj):
        bpy.ops.meanvalue.bake_mix()
    obj.meanvalue.mix.is_on = True
    limbs.set_value(obj, "Other", 0.5)
    assert ("in one place" in status(obj)[0]) == (count < 2)
    obj.meanvalue.mix.is_on = False
    limbs.set_value(obj, "Other", 0.0)
    assert_same(before, snapshot(obj))


def test_a_linked_mesh_is_left_alone(tmp_path):
    limbs.bending()
    path = str(tmp_path / "library.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_empty=True)
    obj = meshes.new_object("Local", libraries.load(path, "meshes", link=True)[0])
    for value in (True, False):
        obj.meanvalue.mix.is_on = value
        bpy.context.view_layer.update()
        assert [key.name for key in limbs.keys_of(obj)] == ["Basis", "Bend"]


def test_undone_and_redone_while_live():
    obj = limbs.mixing(value=0.25)
    bpy.ops.ed.undo_push(message="quarter")
    quarter = limbs.shown(obj)
    limbs.set_value(obj, "Bend", 0.75)
    bpy.ops.ed.undo_push(message="three quarters")
    more = limbs.shown(obj)
    bpy.ops.ed.undo()
    np.testing.assert_allclose(limbs.shown(bpy.data.objects["Limb"]), quarter, atol=1e-4)
    bpy.ops.ed.redo()
    np.testing.assert_allclose(limbs.shown(bpy.data.objects["Limb"]), more, atol=1e-4)


@pytest.mark.parametrize("mode", ['SCULPT', 'WEIGHT_PAINT', 'EDIT'])
def test_mixing_waits_in_other_modes(mode, status):
    obj = limbs.mixing()
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode=mode)
    limbs.set_value(obj, "Bend", 0.25)
    assert status(obj)[1] and "Mode" in status(obj)[0]
    bpy.ops.object.mode_set(mode='OBJECT')
    bpy.context.view_layer.update()
    assert not status(obj)[1]
    assert limbs.miss(obj, bent_limb.bent(limbs.rest(), 35.0)) <= 0.25 * limbs.linear_miss(140.0, 0.25)


def test_live_posing_of_another_object_with_the_mesh_is_told(status):
    obj = limbs.mixing()
    twin = meshes.duplicate(obj, linked=True)
    twin.meanvalue.live = True
    limbs.set_value(obj, "Bend", 0.4)
    said = [status(each)[0] for each in (obj, twin)]
    assert any("has the same mesh" in text for text in said), said
    assert limbs.MIX in limbs.keys_of(obj), "the mix of the other object was not taken away"
