# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertex a press on the surface takes."""

from time import process_time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import handles, meshes

COLUMNS = 31
MIDDLE = COLUMNS * COLUMNS // 2


def test_a_loose_vertex_is_not_what_was_pressed(part):
    obj = meshes.grid(COLUMNS, COLUMNS)
    obj.data.vertices.add(1)
    obj.data.vertices[-1].co = place = np.add(obj.data.vertices[MIDDLE].co, (0.0, 0.0, 0.1))
    handles.update()
    assert part("widgets.picking").vertex_or_image(obj, place)[0] == MIDDLE


def half_sheet(axes=(True, False, False)):
    """7 x 7 quads from the planes of a Mirror modifier, which is the first one."""
    obj = meshes.grid(7, 7, "Half")
    modifier = obj.modifiers.new("Mirror", 'MIRROR')
    modifier.use_axis = axes
    handles.update()
    return obj


def hit(obj, x, y):
    """Place on what is shown of `obj` over (x, y), in its own space, as of a press."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    is_hit, place, _normal, _face = evaluated.ray_cast((x, y, 9.0), (0.0, 0.0, -1.0))
    assert is_hit
    return np.array(place, np.float32)


@pytest.mark.parametrize("x, y", [(5.1, 3.1), (-5.1, 3.1), (5.1, -3.1), (-5.1, -3.1), (-0.8, 2.9), (-0.2, 2.9)])
def test_a_press_on_a_mirror_image_takes_the_vertex_that_it_is_of(part, x, y):
    obj = half_sheet((True, True, False))
    vertex, turn = part("widgets.picking").vertex_or_image(obj, hit(obj, x, y))
    expected = round(abs(y)) * 7 + round(abs(x))
    assert vertex == expected
    own = np.array(obj.data.vertices[expected].co)
    shown = np.array(turn) @ own  # the planes go through the origin
    assert np.allclose(shown[:2], (np.copysign(own[0], x), np.copysign(own[1], y)), atol=1e-6) or abs(x) < 0.5


def test_a_press_on_what_an_array_made_is_refused(part):
    obj = meshes.grid(7, 7, "Tile")
    obj.modifiers.new("Array", 'ARRAY')
    handles.update()
    assert part("widgets.picking").vertex_or_image(obj, hit(obj, 3.1, 3.1))[0] == 24
    assert part("widgets.picking").vertex_or_image(obj, hit(obj, 9.1, 3.1)) is None


def test_a_press_on_an_image_that_is_not_taken_into_account_is_refused(part):
    obj = half_sheet()
    bend = obj.modifiers.new("Bend", 'SIMPLE_DEFORM')
    bend.factor = 0.0
    bpy.ops.object.modifier_move_to_index(modifier="Bend", index=0)
    handles.update()
    assert part("widgets.picking").vertex_or_image(obj, hit(obj, -5.1, 3.1)) is None


def test_a_coarse_face_beside_fine_ones_can_be_pressed_in_its_middle(part):
    fine = [(0.1 * x, 10.0 + 0.1 * y, 0.0) for y in range(3) for x in range(3)]
    faces = [(4 + 3 * y + x, 5 + 3 * y + x, 8 + 3 * y + x, 7 + 3 * y + x) for y in range(2) for x in range(2)]
    obj = meshes.make_object([(0, 0, 0), (30, 0, 0), (30, 9.9, 0), (0, 9.9, 0), *fine], [(0, 1, 2, 3), *faces])
    obj.modifiers.new("Array", 'ARRAY')
    handles.update()
    assert part("widgets.picking").vertex_or_image(obj, hit(obj, 5.0, 7.0)) is not None


def test_the_first_surface_is_the_one_that_blender_finds_and_sooner(part, monkeypatch):
    pressed, add, down, found = part("widgets.picking"), bpy.ops, Vector((0.1, 0.05, -1.0)), []
    monkeypatch.setattr(pressed.views, "is_pressable", lambda obj, context: True)
    ball, ape = add.surface.primitive_nurbs_surface_sphere_add, add.mesh.primitive_monkey_add
    for number, make in enumerate((ape, add.object.text_add, add.mesh.primitive_cylinder_add, ball)):
        make(location=(2.0 * number, 0.0, number), rotation=(0.4 * number, 0.3, 0.0))
        bpy.context.object.scale, copy = (-1.0, 1.5, 0.7), meshes.new_object("Copy")
        copy.instance_type, copy.location = 'COLLECTION', (1.0, 2.0, 0.5)
        copy.instance_collection = bpy.data.collections.new("Copied")
        copy.instance_collection.objects.link(bpy.context.object)
    add.mesh.primitive_ico_sphere_add(subdivisions=8, location=(0.0, 0.0, -4.0))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for at in map(Vector, np.random.default_rng(0).uniform((-2.0, -2.0, 9.0), (8.0, 4.0, 9.0), (150, 3)).tolist()):
        view = SimpleNamespace(region_2d_to_origin_3d=lambda *_, at=at: at, region_2d_to_vector_3d=lambda *_: down)
        monkeypatch.setattr(pressed, "view3d_utils", view)
        ours = process_time(), pressed.first_object(bpy.context, None, None, None)[0], process_time()
        blenders = process_time(), bpy.context.scene.ray_cast(depsgraph, at, down)[4], process_time()
        assert ours[1] == (blenders[1] and blenders[1].original)
        found.append((ours[1], ours[2] - ours[0], blenders[2] - blenders[0]))
    objects, ours, blenders = zip(*found, strict=True)
    assert len(set(objects)) == 6 and max(ours) < 0.3 * max(blenders)
