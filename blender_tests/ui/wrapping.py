# SPDX-License-Identifier: GPL-3.0-or-later
"""Pairs are clicked on both meshes, and Wrap fits one onto the other beside the interface."""

import bpy
import numpy as np
from harness import tabs, view
from mathutils import Vector
from support import installed, meshes


def pairs_are_clicked_and_one_is_fitted_onto_the_other(ui):
    other = _ball("Egg", 14, 20, 2.6)
    other.scale.z = 1.5
    obj = _ball("Ball", 40, 56, 0.0)
    ui.frame_all()
    yield from tabs.open_part(ui, "wrapping")
    other.select_set(True)
    yield from ui.invoke("meanvalue.pick_wrap_pairs")
    assert "'Ball'" in ui.status_text(), ui.status_text()
    for number, place in enumerate(_seen()):
        yield from _pick(ui, place)
        pairs = bpy.data.objects["Ball"].meanvalue.wrap.pairs
        assert len(pairs) == number + 1
        assert np.linalg.norm(np.array(pairs[number].place) - place) < 0.1
        vertex = bpy.data.objects["Ball"].data.vertices[pairs[number].vertex]
        assert np.linalg.norm(np.array(vertex.co) - place) < 0.1
    yield from ui.click(*ui.project(_on(bpy.data.objects["Ball"], _front())))
    yield from ui.key('BACK_SPACE')
    assert "'Ball'" in ui.status_text(), "half a pair is taken back"
    yield from ui.key('BACK_SPACE')
    assert len(bpy.data.objects["Ball"].meanvalue.wrap.pairs) == 2
    yield from _pick(ui, _seen()[2])
    yield from ui.key('RET')
    assert ui.status_text() is None
    yield from ui.screenshot("wrap_01_picked")
    bpy.data.objects["Ball"].meanvalue.show_overlay = False
    yield from ui.screenshot("wrap_01_without_lines")
    assert _share_that_differs(ui, "wrap_01_picked", "wrap_01_without_lines") > 0.9
    bpy.data.objects["Ball"].meanvalue.show_overlay = True

    yield from ui.invoke("meanvalue.wrap")
    yield from ui.wait_until(lambda: bpy.data.objects["Ball"].data.shape_keys is not None, "the mesh is fitted")
    obj = bpy.data.objects["Ball"]
    key = obj.data.shape_keys.key_blocks["Egg"]
    height = np.ptp([point.co.z for point in key.data])
    assert abs(height - 3.0) < 0.1, height
    yield from ui.screenshot("wrap_02_fitted")
    ends = installed.part("wrapping.bridge.wrap_scene").lines(obj).ends.reshape(-1, 2, 3)
    distances = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    assert len(ends) == 3 and distances.max() < 0.15, distances  # half an edge: what was picked are vertices


def _pick(ui, place):
    yield from ui.click(*ui.project(_on(bpy.data.objects["Ball"], place)))
    assert "'Egg'" in ui.status_text(), ui.status_text()
    yield from ui.click(*ui.project(_on(bpy.data.objects["Egg"], place)))


def _share_that_differs(ui, one, other):
    """Between two pictures, of all places along the lines of the pairs."""
    pictures = [ui.picture(name) for name in (one, other)]
    obj, target = bpy.data.objects["Ball"], bpy.data.objects["Egg"]
    differs = []
    for pair in obj.meanvalue.wrap.pairs:
        begin = obj.matrix_world @ obj.data.vertices[pair.vertex].co
        end = target.matrix_world @ Vector(pair.place)
        for share in np.linspace(0.1, 0.9, 17):
            x, y = (round(value) for value in ui.project(begin.lerp(end, share)))
            around = [picture[y - 2 : y + 3, x - 2 : x + 3, :3] for picture in pictures]
            differs.append(np.abs(around[0] - around[1]).max() > 0.1)
    return np.mean(differs)


def _seen():
    """Three places of a unit ball that are in front."""
    axes = np.array(view.area().spaces.active.region_3d.view_matrix)[:3, :3]
    places = np.array([(0.6, 0.0, 1.0), (-0.5, 0.5, 1.0), (0.0, -0.6, 1.0)]) @ axes
    return places / np.linalg.norm(places, axis=1, keepdims=True)


def _front():
    """The place of a unit ball that is nearest to the eye."""
    return np.array(view.area().spaces.active.region_3d.view_matrix)[2, :3]


def _on(obj, place):
    return obj.matrix_world @ Vector(place)


def _ball(name, rings, around, x):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=around, ring_count=rings)
    obj = bpy.context.object
    obj.name = obj.data.name = name
    obj.location.x = x
    bpy.context.view_layer.update()
    meshes.activate(obj)
    return obj
