# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows, without a display: pictures of it are in ui/overlay_pictures.py."""

from unittest import mock

import bpy
import mathutils
import numpy as np
import pytest
from support import meshes, steps

REGION = [0, 1, 2, 5, 6, 7]


@pytest.fixture
def data(part):
    return part("posing.ui.overlay")


def grid_with_anchors():
    obj = meshes.grid()
    steps.list_anchors(obj, Corner=[0, 4], Tip=[24])
    obj.meanvalue.handles["Corner"].color = (1.0, 0.0, 0.0)
    obj.meanvalue.handles["Tip"].color = (0.0, 0.0, 1.0)
    return obj


def add_region(obj):
    steps.add_group(obj, "Region", REGION)
    obj.meanvalue.roi_group = "Region"


def test_anchors_in_the_colours_of_their_handles(data):
    obj = grid_with_anchors()
    look = data.look_of(obj)
    rest = np.array([vertex.co for vertex in obj.data.vertices], np.float32)
    assert np.array_equal(look.points, rest[[0, 4, 24]])
    red, blue = (1, 0, 0, 1), (0, 0, 1, 1)
    assert look.colors.tolist() == [list(red), list(red), list(blue)]
    assert look.points.dtype == look.colors.dtype == np.float32
    assert len(look.corners) == 0


def test_a_patch_is_shown_by_its_outline(data):
    obj = meshes.grid()
    block = [0, 1, 2, 5, 6, 7, 10, 11, 12]
    steps.list_anchors(obj, Block=block)
    rest = np.array([vertex.co for vertex in obj.data.vertices], np.float32)
    assert np.array_equal(data.look_of(obj).points, rest[[2, 7, 10, 11, 12]])
    steps.list_anchors(meshes.grid(3, 3, "Whole"), Whole=range(9))
    assert len(data.look_of(bpy.data.objects["Whole"]).points) == 9


def test_disabled_and_missing_handles_are_left_out(data):
    obj = grid_with_anchors()
    obj.meanvalue.handles["Corner"].is_enabled = False
    assert len(data.look_of(obj).points) == 1
    obj.vertex_groups.remove(obj.vertex_groups["Tip"])
    look = data.look_of(obj)
    assert (len(look.points), len(look.colors)) == (0, 0)


def test_the_regions_faces(data):
    obj = grid_with_anchors()
    add_region(obj)
    look = data.look_of(obj)
    assert sorted(map(tuple, look.tint[:, :2].tolist())) == [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]
    assert len(look.corners) == 4, "two quads"
    obj.meanvalue.roi_group = ""
    assert len(data.look_of(obj).corners) == 0


def test_a_place_that_is_no_number_does_not_end_the_drawing(data):
    obj = grid_with_anchors()
    add_region(obj)
    expected = data.look_of(obj)
    obj.data.vertices[7].co.x = float("nan")
    obj.update_tag()
    bpy.context.view_layer.update()
    look = data.look_of(obj)
    assert np.array_equal(look.points, expected.points) and np.array_equal(look.corners, expected.corners)


def test_what_moves_less_is_fainter(data):
    obj = grid_with_anchors()
    group = obj.vertex_groups.new(name="Region")
    weights = dict(zip(REGION, (1.0, 0.5, 0.25, 1.0, 0.75, 1.0), strict=True))
    for vertex, weight in weights.items():
        group.add([vertex], weight, 'REPLACE')
    obj.meanvalue.roi_group = "Region"
    look = data.look_of(obj)
    assert look.freedom.tolist() == [weights[vertex] for vertex in sorted(REGION)]


def test_with_symmetric_both_sides_are_shown(data):
    """Flat, with the origin in its middle: corners 0 and 4 are each other's images, 20 is that of the tip."""
    obj = grid_with_anchors()
    add_region(obj)
    places = np.array([vertex.co for vertex in obj.data.vertices]) * (1.0, 1.0, 0.0) - (2.0, 2.0, 0.0)
    obj.data.vertices.foreach_set("co", places.ravel())
    obj.data.update()
    bpy.context.view_layer.update()
    obj.meanvalue.symmetric = 'X'
    look = data.look_of(obj)
    assert look.points.tolist() == places[[0, 4, 24, 20]].tolist()
    red, blue = [1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]
    assert look.colors.tolist() == [red, red, blue, blue]
    assert sorted(set(look.tint[:, 0].tolist())) == [-2.0, -1.0, 0.0, 1.0, 2.0], "the region on both sides"


def test_on_a_subdivided_mesh_points_lie_on_the_surface_that_is_seen(data):
    obj = grid_with_anchors()
    obj.modifiers.new("Finer", 'SUBSURF').levels = 2
    bpy.context.view_layer.update()
    evaluated = obj.evaluated_get(bpy.context.view_layer.depsgraph)
    for place in data.look_of(obj).points:
        _is_hit, nearest, _normal, _face = evaluated.closest_point_on_mesh(place.tolist())
        assert np.abs(np.subtract(nearest, place)).max() < 1e-5


def test_positions_are_those_of_the_result_where_it_is_shown(data):
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    add_region(obj)
    key = obj.data.shape_keys.key_blocks["Mean-Value"]
    result, rest = steps.key_positions(obj, "Mean-Value"), steps.key_positions(obj, "Basis")
    assert np.abs(data.look_of(obj).points - result[[0, 4, 20, 24]]).max() < 1e-6
    assert np.abs(data.look_of(obj).tint - result[REGION]).max() < 1e-6
    key.mute = True
    bpy.context.view_layer.update()
    assert np.array_equal(data.look_of(obj).points, rest[[0, 4, 20, 24]])


def test_modifiers_that_move_vertices_count(data):
    obj = grid_with_anchors()
    modifier = obj.modifiers.new("Push", 'DISPLACE')
    modifier.direction = 'X'
    modifier.mid_level = 0.0
    modifier.strength = 3.0
    bpy.context.view_layer.update()
    assert np.allclose(data.look_of(obj).points[:, 0], [3.0, 7.0, 7.0])


@pytest.mark.parametrize("is_shown", [True, False])
def test_with_other_vertices_after_modifiers_it_is_the_shape_key(data, is_shown):
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    obj.data.shape_keys.key_blocks["Mean-Value"].mute = not is_shown
    obj.modifiers.new("Mirror", 'MIRROR')
    bpy.context.view_layer.update()
    expected = steps.key_positions(obj, "Mean-Value" if is_shown else "Basis")
    assert np.array_equal(data.look_of(obj).points, expected[[0, 4, 20, 24]])


def test_what_a_handler_writes_is_seen_at_once(data):
    """Blender evaluates it without telling anybody."""
    obj = meshes.grid()
    steps.list_anchors(obj, Corners=[0, 4, 20])
    steps.add_handle(obj, "Hand", [24])
    bpy.context.view_layer.update()
    before = data.look_of(obj).points.copy()
    obj.meanvalue.handles["Hand"].control.location.z += 1.0
    bpy.context.view_layer.update()
    assert data.look_of(obj).points[3, 2] == pytest.approx(before[3, 2] + 1.0, abs=1e-4)


def test_another_mesh_and_other_vertices(data):
    obj = grid_with_anchors()
    add_region(obj)
    data.look_of(obj)
    steps.edit_mesh(obj, lambda bm: bm.verts.remove(list(bm.verts)[7]))
    assert len(data.look_of(obj).points) == 3
    assert len(data.look_of(obj).corners) == 2, "one quad is left"


def test_an_empty_mesh(data):
    look = data.look_of(meshes.make_object([], []))
    assert (len(look.points), len(look.corners)) == (0, 0)


PERSPECTIVE = mathutils.Matrix(((2, 0, 0, 0), (0, 2, 0, 0), (0, 0, -1.002, -0.2002), (0, 0, -1, 0)))
ORTHOGRAPHIC = mathutils.Matrix(((0.1, 0, 0, 0), (0, 0.1, 0, 0), (0, 0, -0.002, 0), (0, 0, 0, 1)))


@pytest.mark.parametrize("projection", [PERSPECTIVE, ORTHOGRAPHIC])
def test_closer_is_in_front_and_at_the_same_place(part, projection):
    def seen(matrix, point):
        clip = matrix @ mathutils.Vector((*point, 1.0))
        return [value / clip.w for value in clip[:3]]

    moved = part("posing.ui.overlay").closer(projection, 20.0, 0.01)
    for point in ((0.0, 0.0, -20.0), (3.0, -2.0, -15.0)):
        before, after = seen(projection, point), seen(moved, point)
        assert after[:2] == pytest.approx(before[:2])
        assert after[2] < before[2]


def test_a_popup_comes_in_the_window_where_an_operator_ran_last(part, monkeypatch):
    windows, seen = [mock.MagicMock() for _number in range(3)], mock.MagicMock()
    seen.context.window_manager.windows = windows
    monkeypatch.setattr(part("scene.views"), "bpy", seen)
    for seen.context.window in (windows[1], windows[2], None):
        part("widgets.base").Reporting.tell(mock.MagicMock(), "Done", [])
        part("scene.views").pop_up("Mean-Value", "Look")
    shown = [call.kwargs["window"] for call in seen.context.temp_override.call_args_list]
    assert shown == [windows[1], windows[2], windows[2]]
