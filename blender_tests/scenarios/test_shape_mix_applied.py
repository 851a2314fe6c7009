# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose becomes the rest shape (Apply as Rest, Finish) while the shape keys are mixed, live or by in-between keys."""

import bpy
import numpy as np
import pytest
from support import bent_limb, meshes, steps
from support.mixed_limbs import bake, bending, in_betweens_of, keys_of, mixing, rest, set_value, shown

LEANED = bent_limb.bent(rest(), 40.0)

APPLY = {
    "apply": lambda: bpy.ops.meanvalue.apply_pose(),
    "finish": lambda: bpy.ops.meanvalue.finish(keep='REST'),
}


def lean(obj):
    """A pose, as posing by handles leaves it: a result key that is shown fully."""
    key = steps.add_key(obj, "Mean-Value", LEANED)
    key.value = 1.0
    obj.meanvalue.result_key = key.name
    bpy.context.view_layer.update()


def added(obj, name):
    """What a key adds to the rest shape."""
    return steps.key_positions(obj, name) - steps.key_positions(obj, "Basis")


def all_keys(obj):
    return {key.name: steps.key_positions(obj, key.name) for key in keys_of(obj)}


@pytest.mark.parametrize("apply", APPLY.values(), ids=APPLY)
@pytest.mark.parametrize("value", [0.0, 0.5, 1.0])
def test_the_artist_s_keys_add_what_they_added(apply, value):
    obj = mixing(value=value)
    lean(obj)
    before = added(obj, "Bend")
    meshes.activate(obj)
    assert apply() == {'FINISHED'}
    bpy.context.view_layer.update()
    np.testing.assert_allclose(steps.key_positions(obj, "Basis"), LEANED, atol=1e-5)
    np.testing.assert_allclose(added(obj, "Bend"), before, atol=1e-5)
    assert keys_of(obj)["Bend"].value == value and not keys_of(obj)["Bend"].mute
    assert obj.meanvalue.mix.is_on
    for end in (0.0, 1.0):  # straight at the ends of the slider, whatever is between
        set_value(obj, "Bend", end)
        np.testing.assert_allclose(shown(obj), LEANED + end * before, atol=1e-3)
    obj.meanvalue.mix.is_on = False
    set_value(obj, "Bend", 0.5)
    np.testing.assert_allclose(shown(obj), LEANED + 0.5 * before, atol=1e-4)


@pytest.mark.parametrize("apply", APPLY.values(), ids=APPLY)
def test_in_betweens_go_along_and_bake_mix_is_asked_for(apply, capfd):
    obj = bending()
    bake(obj)
    set_value(obj, "Bend", 0.5)
    lean(obj)
    before, made = shown(obj), in_betweens_of(obj)
    expressions = [curve.driver.expression for curve in obj.data.shape_keys.animation_data.drivers]
    meshes.activate(obj)
    assert apply() == {'FINISHED'}
    said = capfd.readouterr().out
    assert f"{len(made)} in-between keys of Bake Mix" in said and "'Bend'" in said
    assert not any(f"'{name}'" in said for name in made), "these are not the artist's"
    bpy.context.view_layer.update()
    np.testing.assert_allclose(shown(obj), before, atol=1e-4)
    assert in_betweens_of(obj) == made
    assert [curve.driver.expression for curve in obj.data.shape_keys.animation_data.drivers] == expressions
    bake(obj)
    assert bpy.ops.meanvalue.bake_mix(remove=True) == {'FINISHED'}
    assert [key.name for key in keys_of(obj)][:2] == ["Basis", "Bend"]


@pytest.mark.parametrize("is_baked", [False, True], ids=["live", "baked"])
def test_undo_brings_all_keys_back(is_baked):
    obj = bending()
    if is_baked:
        bake(obj)
    else:
        obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.5)
    lean(obj)
    meshes.activate(obj)
    bpy.ops.ed.undo_push(message="before")
    before, looks = all_keys(obj), shown(obj)
    assert bpy.ops.meanvalue.apply_pose() == {'FINISHED'}
    bpy.ops.ed.undo_push(message="applied")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Limb"]
    bpy.context.view_layer.update()
    after = all_keys(obj)
    assert list(after) == list(before)
    for name, shape in before.items():
        np.testing.assert_allclose(after[name], shape, atol=1e-5, err_msg=name)
    np.testing.assert_allclose(shown(obj), looks, atol=1e-4)
