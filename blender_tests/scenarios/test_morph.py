# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of another object, whole or in part, as a slider."""

import math

import bpy
import numpy as np
import pytest
from support import bent_limb, meshes, steps
from support.mixed_limbs import bending, limb, linear_miss, miss, rest, shown
from support.snapshot import assert_same, snapshot


def test_the_shape_of_another_object_becomes_a_slider():
    other = bending()
    other.data.shape_keys.key_blocks["Bend"].value = 1.0
    obj = limb("Straight")
    assert bpy.ops.meanvalue.morph(source="Limb", value=0.5) == {'FINISHED'}
    assert obj.meanvalue.mix.is_on
    assert miss(obj, bent_limb.bent(rest(), 70.0)) <= 0.25 * linear_miss(140.0, 0.5)
    np.testing.assert_allclose(steps.key_positions(obj, "Limb"), bent_limb.bent(rest(), 140.0), atol=1e-5)


def test_a_part_of_another_object_keeps_its_shape_and_meets_the_border():
    """A thicker end, elsewhere and turned, is put on the limb's own."""
    shape = rest()
    thick = np.clip((shape[:, 0] - 4.0) / 0.5, 0.0, 1.0)
    source_shape = shape.copy()
    source_shape[:, 1:] *= (1.0 + 0.6 * thick)[:, None]
    source_shape = source_shape[:, [1, 0, 2]] * (1.0, -1.0, 1.0) + (3.0, 1.0, 9.0)
    meshes.make_object(source_shape.tolist(), bent_limb.limb()[1], "Thick")
    obj = limb()
    steps.add_weights(obj, "End", np.clip((shape[:, 0] - 3.5) / 0.5, 0.0, 1.0))
    assert bpy.ops.meanvalue.morph(source="Thick", part="End") == {'FINISHED'}
    placed = shown(obj)
    radii = np.linalg.norm(placed[:, 1:] - placed[:, 1:].mean(axis=0), axis=1)
    end, start = shape[:, 0] > 5.0, shape[:, 0] < 2.5
    np.testing.assert_allclose(radii[end], 1.6 * bent_limb.RADIUS, rtol=0.1)
    np.testing.assert_allclose(radii[start], bent_limb.RADIUS, rtol=0.05)


def test_what_cannot_be_the_other_shape_is_refused():
    limb_shape, faces = bent_limb.limb()
    meshes.make_object(limb_shape.tolist(), [faces[-1], *faces[:-1]], "Shuffled")
    meshes.grid()
    obj = bending()
    before = snapshot(obj)
    for source, texts in (("Grid", ["25 vertices", "Wrap"]), ("Shuffled", ["faces"])):
        with steps.refused(*texts):
            bpy.ops.meanvalue.morph(source=source)
        assert_same(before, snapshot(obj))


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


SMALL = {"scale": (0.01, 0.01, 0.01)}


@pytest.mark.parametrize(
    "change, place",
    [
        (lambda points: 100.0 * points, SMALL),
        (lambda points: points - (0.0, 0.0, 1.0), {"location": (0.0, 0.0, 1.0)}),
        (lambda points: points[:, [0, 2, 1]] * (1.0, 1.0, -1.0), {"rotation_euler": (math.pi / 2.0, 0.0, 0.0)}),
        (lambda points: 100.0 * points, {**SMALL, "location": (0.0, 9.0, 0.0)}),
    ],
)
def test_the_other_counts_as_it_is_to_be_seen(change, place, capfd):
    """With its scale, its turn, and where it stands. One that stands beside does not carry the mesh off."""
    shape, faces = bent_limb.bent(rest(), 20.0), bent_limb.limb()[1]
    other = meshes.make_object(change(shape).tolist(), faces, "Other")
    for name, value in place.items():
        setattr(other, name, value)
    obj = limb("Straight")
    bpy.context.view_layer.update()
    assert bpy.ops.meanvalue.morph(source="Other") == {'FINISHED'}
    np.testing.assert_allclose(shown(obj), shape, atol=1e-5)
    assert ("stands elsewhere" in capfd.readouterr().out) == (len(place) == 2)
