# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that turn: mixed live, baked to in-between keys with drivers, from other objects and in part."""

import bpy
import numpy as np
import pytest
from support import bent_limb, installed, meshes, steps
from support.interface import interface, is_settled
from support.snapshot import assert_same, snapshot

DIAGONAL = float(np.hypot(bent_limb.LENGTH, 2.0 * bent_limb.RADIUS))


def limb(name="Limb", **shapes):
    """A straight limb with a shape key for each of `shapes`, {name: n x 3}."""
    rest, faces = bent_limb.limb()
    obj = meshes.make_object(rest.tolist(), faces, name)
    obj.shape_key_add(name="Basis")
    for key_name, shape in shapes.items():
        key = obj.shape_key_add(name=key_name, from_mix=False)
        key.data.foreach_set("co", shape.astype(np.float32).ravel())
        key.value = 0.0  # of a new one it is 1 from Blender 5.2 on
    return obj


def rest():
    return bent_limb.limb()[0]


def bending(degrees=140.0):
    return limb(Bend=bent_limb.bent(rest(), degrees))


def shown(obj):
    """n x 3: what Blender makes of the keys."""
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    positions = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3).astype(np.float64)


def status(obj):
    """(text, whether it is a problem) of the panel."""
    return installed.part("live.engine").status(obj) or ("", False)


def set_value(obj, name, value):
    obj.data.shape_keys.key_blocks[name].value = value
    bpy.context.view_layer.update()


def miss(obj, truth):
    """rms distance, after the best rigid fit: where a mix without anchors stands is not said by its shapes."""
    fit_rotations = installed.part("scene.core.rigid").fit_rotations
    placed = shown(obj)
    rotation = fit_rotations(placed, truth)
    off = (placed - placed.mean(axis=0)) @ rotation.T - (truth - truth.mean(axis=0))
    return float(np.sqrt((off**2).sum(axis=1).mean()))


def linear_miss(degrees, share):
    straight = rest() + share * (bent_limb.bent(rest(), degrees) - rest())
    truth = bent_limb.bent(rest(), share * degrees)
    return float(np.sqrt((((straight - straight.mean(0)) - (truth - truth.mean(0))) ** 2).sum(axis=1).mean()))


@pytest.mark.parametrize("share", [0.25, 0.5, 0.75])
def test_a_mixed_bend_follows_the_arc(share):
    obj = bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", share)
    assert miss(obj, bent_limb.bent(rest(), share * 140.0)) <= 0.25 * linear_miss(140.0, share)


def test_a_dragged_slider_settles_to_what_its_value_alone_says():
    obj = bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.52)
    expected = shown(obj)
    set_value(obj, "Bend", 0.2)
    with interface() as timers:
        for value in np.linspace(0.24, 0.52, 8):  # no time passes: it is dragged
            set_value(obj, "Bend", value)
        assert np.abs(shown(obj) - expected).max() <= 2e-3 * DIAGONAL
        timers.run(0.1)
        assert is_settled(obj)
        np.testing.assert_array_equal(shown(obj), expected)


def test_the_ends_are_the_keys_themselves():
    obj = bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.5)
    for value, truth in ((1.0, bent_limb.bent(rest(), 140.0)), (0.0, rest())):
        set_value(obj, "Bend", value)
        np.testing.assert_allclose(shown(obj), truth, atol=1e-5)


def test_off_it_goes_in_straight_lines_again():
    obj = bending()
    before = snapshot(obj)
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.5)
    assert "Rotation-Aware Mix" in obj.data.shape_keys.key_blocks
    obj.meanvalue.mix.is_on = False
    set_value(obj, "Bend", 0.0)
    assert_same(before, snapshot(obj))


def test_live_posing_and_mixing_take_turns():
    obj = bending()
    obj.meanvalue.mix.is_on = True
    obj.meanvalue.live = True
    assert not obj.meanvalue.mix.is_on and "Rotation-Aware Mix" not in obj.data.shape_keys.key_blocks
    obj.meanvalue.mix.is_on = True
    assert not obj.meanvalue.live


def test_an_edited_key_is_mixed_as_it_is_now():
    obj = bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.5)
    key = obj.data.shape_keys.key_blocks["Bend"]
    key.data.foreach_set("co", bent_limb.bent(rest(), -90.0).astype(np.float32).ravel())
    obj.data.update_tag()
    set_value(obj, "Bend", 0.501)
    assert miss(obj, bent_limb.bent(rest(), -45.1)) <= 0.25 * linear_miss(-90.0, 0.5)


def in_betweens_of(obj):
    """Names of the keys that Bake Mix has made: those that are driven."""
    animation = obj.data.shape_keys.animation_data
    paths = {curve.data_path for curve in animation.drivers} if animation else ()
    return [key.name for key in obj.data.shape_keys.key_blocks if key.path_from_id("value") in paths]


def bake(obj, share=0.2):
    obj.meanvalue.mix.tolerance_share = share
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bake_mix() == {'FINISHED'}


def test_baked_in_betweens_are_within_the_tolerance_and_need_no_addon():
    obj = bending()
    obj.meanvalue.mix.is_on = True
    shapes = {}
    values = [0.0, 1.0, *np.random.default_rng(11).uniform(0.0, 1.0, 8)]
    for value in values:
        set_value(obj, "Bend", value)
        shapes[value] = shown(obj)
    bake(obj)
    assert not obj.meanvalue.mix.is_on and "Rotation-Aware Mix" not in obj.data.shape_keys.key_blocks
    made = in_betweens_of(obj)
    assert 1 <= len(made) <= 6
    installed.disable()
    try:
        for value in values:
            set_value(obj, "Bend", value)
            assert np.linalg.norm(shown(obj) - shapes[value], axis=1).max() <= 0.002 * DIAGONAL
    finally:
        installed.enable()


def test_two_sliders_baked_together():
    obj = limb(Bend=bent_limb.bent(rest(), 110.0), Twist=bent_limb.twisted(rest(), 120.0))
    obj.meanvalue.mix.is_on = True
    settings = np.random.default_rng(5).uniform(0.0, 1.0, (6, 2))
    truths = []
    for bend, twist in settings:
        set_value(obj, "Bend", bend)
        set_value(obj, "Twist", twist)
        truths.append(shown(obj))
    bake(obj, 1.0)
    for (bend, twist), truth in zip(settings, truths, strict=True):
        set_value(obj, "Bend", bend)
        set_value(obj, "Twist", twist)
        assert np.linalg.norm(shown(obj) - truth, axis=1).max() <= 1.5 * 0.01 * DIAGONAL


def masked_and_bending():
    """A key that is thicker in the last third alone, by a group with a soft edge, beside one that bends all."""
    obj = limb(Thick=rest() * (1.0, 1.5, 1.5), Bend=bent_limb.bent(rest(), 110.0))
    group = obj.vertex_groups.new(name="Tail")
    for index, weight in enumerate(np.clip((rest()[:, 0] - 3.5) / 0.5, 0.0, 1.0)):
        if weight > 0.0:
            group.add([index], float(weight), 'REPLACE')
    obj.data.shape_keys.key_blocks["Thick"].vertex_group = "Tail"
    return obj


def test_a_masked_slider_beside_another_is_baked_within_the_tolerance():
    obj = masked_and_bending()
    obj.meanvalue.mix.is_on = True
    settings = np.random.default_rng(6).uniform(0.0, 1.0, (8, 2))
    truths = []
    for thick, bend in settings:
        set_value(obj, "Thick", thick)
        set_value(obj, "Bend", bend)
        truths.append(shown(obj))
    bake(obj)
    assert len(in_betweens_of(obj)) <= 15
    for (thick, bend), truth in zip(settings, truths, strict=True):
        set_value(obj, "Thick", thick)
        set_value(obj, "Bend", bend)
        assert np.linalg.norm(shown(obj) - truth, axis=1).max() <= 0.002 * DIAGONAL


def test_a_masked_slider_does_not_make_the_mesh_jump():
    obj = masked_and_bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Thick", 0.6)
    shapes = []
    for bend in np.linspace(0.0, 1.0, 21):
        set_value(obj, "Bend", bend)
        shapes.append(shown(obj))
    assert np.linalg.norm(np.diff(shapes, axis=0), axis=2).max() <= 0.1 * DIAGONAL
    set_value(obj, "Thick", 0.0)
    np.testing.assert_allclose(shown(obj), bent_limb.bent(rest(), 110.0), atol=1e-5)


def test_in_betweens_taken_back_leave_nothing():
    obj = bending()
    before = snapshot(obj, without=("settings",))
    bake(obj)
    assert bpy.ops.meanvalue.bake_mix(remove=True) == {'FINISHED'}
    assert_same(before, snapshot(obj, without=("settings",)))
    animation = obj.data.shape_keys.animation_data
    assert animation is None or len(animation.drivers) == 0


def test_baking_anew_replaces_the_in_betweens():
    obj = bending()
    bake(obj)
    first = in_betweens_of(obj)
    bake(obj)
    assert in_betweens_of(obj) == first
    assert len(obj.data.shape_keys.key_blocks) == 2 + len(first)


def test_live_mixing_waits_while_in_betweens_stand_for_it():
    obj = bending()
    bake(obj)
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.4)
    assert "Remove In-Betweens" in status(obj)[0]
    assert "Rotation-Aware Mix" not in obj.data.shape_keys.key_blocks


def test_straight_keys_need_no_in_betweens():
    obj = limb(Longer=rest() * (1.05, 1.0, 1.0))
    with steps.refused("No in-between keys are needed"):
        bake(obj, 5.0)


def test_the_shape_of_another_object_becomes_a_slider():
    other = bending()
    other.data.shape_keys.key_blocks["Bend"].value = 1.0
    obj = limb("Straight")
    assert bpy.ops.meanvalue.morph(source="Limb", value=0.5) == {'FINISHED'}
    assert obj.meanvalue.mix.is_on
    assert miss(obj, bent_limb.bent(rest(), 70.0)) <= 0.25 * linear_miss(140.0, 0.5)
    np.testing.assert_allclose(steps.key_positions(obj, "Limb"), bent_limb.bent(rest(), 140.0), atol=1e-5)


def test_the_other_selected_mesh_is_the_source():
    other = bending()
    obj = limb("Straight")
    with steps.refused("0 other meshes are selected"):
        bpy.ops.meanvalue.morph()
    other.select_set(True)
    assert bpy.ops.meanvalue.morph() == {'FINISHED'}
    assert "Limb" in obj.data.shape_keys.key_blocks


def test_a_part_of_another_object_keeps_its_shape_and_meets_the_border():
    """A thicker end, elsewhere and turned, is put on the limb's own."""
    shape = rest()
    thick = np.clip((shape[:, 0] - 4.0) / 0.5, 0.0, 1.0)
    source_shape = shape.copy()
    source_shape[:, 1:] *= (1.0 + 0.6 * thick)[:, None]
    source_shape = source_shape[:, [1, 0, 2]] * (1.0, -1.0, 1.0) + (3.0, 1.0, 9.0)
    meshes.make_object(source_shape.tolist(), bent_limb.limb()[1], "Thick")
    obj = limb()
    group = obj.vertex_groups.new(name="End")
    for index, weight in enumerate(np.clip((shape[:, 0] - 3.5) / 0.5, 0.0, 1.0)):
        if weight > 0.0:
            group.add([index], float(weight), 'REPLACE')
    assert bpy.ops.meanvalue.morph(source="Thick", part="End") == {'FINISHED'}
    placed = shown(obj)
    radii = np.linalg.norm(placed[:, 1:] - placed[:, 1:].mean(axis=0), axis=1)
    end, start = shape[:, 0] > 5.0, shape[:, 0] < 2.5
    np.testing.assert_allclose(radii[end], 1.6 * bent_limb.RADIUS, rtol=0.1)
    np.testing.assert_allclose(radii[start], bent_limb.RADIUS, rtol=0.05)


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
    obj = bending()
    obj.vertex_groups.new(name="Gone")
    spoil(obj)
    if obj.data.shape_keys:
        obj.vertex_groups.clear()
    before = snapshot(obj)
    with steps.refused(*texts):
        bpy.ops.meanvalue.bake_mix()
    assert_same(before, snapshot(obj))


def relate_to_another(obj):
    key = obj.shape_key_add(name="Other", from_mix=False)
    key.relative_key = obj.data.shape_keys.key_blocks["Bend"]


def put_nan(obj):
    obj.data.shape_keys.key_blocks["Bend"].data[3].co.x = float("nan")


def test_the_shape_is_that_of_the_other_selected_mesh():
    other = limb("Other")
    third = limb("Third")
    obj = limb("Straight")
    with steps.refused("0 other meshes"):
        bpy.ops.meanvalue.morph()
    other.select_set(True)
    third.select_set(True)
    with steps.refused("2 other meshes"):
        bpy.ops.meanvalue.morph()
    third.select_set(False)
    with steps.refused("'Nowhere'"):
        bpy.ops.meanvalue.morph(part="Nowhere")
    assert bpy.ops.meanvalue.morph() == {'FINISHED'}
    assert other.name in obj.data.shape_keys.key_blocks


def test_another_number_of_vertices_is_told_with_both():
    obj = bending()
    other = meshes.grid()
    meshes.activate(obj)
    before = snapshot(obj)
    with steps.refused("25 vertices", f"{len(obj.data.vertices):,}", "Wrap"):
        bpy.ops.meanvalue.morph(source=other.name)
    assert_same(before, snapshot(obj))


def test_other_faces_are_told():
    rest_shape, faces = bent_limb.limb()
    other = meshes.make_object(rest_shape.tolist(), [faces[-1], *faces[:-1]], "Shuffled")
    limb()
    with steps.refused("faces", "same faces"):
        bpy.ops.meanvalue.morph(source=other.name)


def test_undo_and_reload_keep_the_mix(tmp_path):
    obj = bending()
    obj.meanvalue.mix.is_on = True
    set_value(obj, "Bend", 0.5)
    before = shown(obj)
    path = str(tmp_path / "mix.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects["Limb"]
    assert obj.meanvalue.mix.is_on
    np.testing.assert_allclose(shown(obj), before, atol=1e-5)
    set_value(obj, "Bend", 0.25)
    assert miss(obj, bent_limb.bent(rest(), 35.0)) <= 0.25 * linear_miss(140.0, 0.25)


def animate(obj, frames=12):
    key = obj.data.shape_keys.key_blocks["Bend"]
    for frame, value in ((1, 0.0), (frames, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, frames


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
def test_animated_sliders_are_baked_frame_by_frame(tmp_path, target):
    obj = bending()
    animate(obj)
    obj.meanvalue.mix.is_on = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mix.blend"))
    obj = bpy.data.objects["Limb"]
    meshes.activate(obj)
    bpy.context.scene.frame_set(1)
    before = snapshot(obj, without=("settings",))
    live = {}
    for frame in (1, 4, 9, 12):
        bpy.context.scene.frame_set(frame)
        live[frame] = shown(obj)
    bpy.context.scene.frame_set(1)
    assert bpy.ops.meanvalue.bake(target=target, keys='EVERY') == {'FINISHED'}
    assert not obj.meanvalue.mix.is_on
    for frame, shape in live.items():
        bpy.context.scene.frame_set(frame)
        assert np.abs(shown(obj) - shape).max() <= 1e-3 * DIAGONAL
    assert bpy.ops.meanvalue.bake(target=target, keys='EVERY') == {'FINISHED'}  # nothing has changed
    bpy.context.scene.frame_set(1)
    assert bpy.ops.meanvalue.unbake() == {'FINISHED'}
    assert obj.meanvalue.mix.is_on
    assert_same(before, snapshot(obj, without=("settings",)))
