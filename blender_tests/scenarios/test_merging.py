# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams with regions and handles: an open seam behaves as the mesh that is joined there, with no setting."""

import re

import bpy
import numpy as np
import pytest
from support import handles, installed, meshes, steps
from support.handles import rest, shown
from support.sheets import region_weights

#: Quads on a side of each half.
SIDE = 15


def height(x, y):
    return 0.05 * np.sin(np.abs(x) + y)


def surface(columns, faces_of, name):
    """The surface over x = -SIDE to SIDE, y = 0 to SIDE, of the blocks of columns that are given."""
    vertices, faces = [], []
    for low, high in columns:
        first, width = len(vertices), high - low + 1
        vertices += [(x, y, height(x, y)) for y in range(SIDE + 1) for x in range(low, high + 1)]
        faces += [tuple(first + each for each in face) for face in meshes.grid_faces(width, SIDE + 1)]
    return meshes.make_object(*faces_of(vertices, faces), name)


def as_it_is(vertices, faces):
    return vertices, faces


def joined():
    return surface([(-SIDE, SIDE)], as_it_is, "Joined")


def open_seam():
    return surface([(-SIDE, 0), (0, SIDE)], as_it_is, "Seam")


def split_faces():
    return surface([(-SIDE, SIDE)], meshes.split, "Split")


def positions(obj):
    return np.array([tuple(vertex.co) for vertex in obj.data.vertices])


def at(obj, x, y):
    """Numbers of the vertices over (x, y)."""
    return np.flatnonzero((np.abs(positions(obj)[:, :2] - (x, y)) < 1e-4).all(axis=1))


def over(obj, condition):
    """Numbers of the vertices whose x and y fulfil a condition."""
    x, y, _ = positions(obj).T
    return np.flatnonzero(condition(x, y)).tolist()


def lifts(obj):
    """{(x, y): [how far each vertex there was lifted]}."""
    found = {}
    for place, lift in zip(np.round(positions(obj)[:, :2]).astype(int), (shown(obj) - rest(obj))[:, 2], strict=True):
        found.setdefault(tuple(place), []).append(float(lift))
    return found


def assert_lifted_alike(obj, expected):
    for place, found in lifts(obj).items():
        assert np.ptp(found) < 1e-5, place  # copies stay together
        assert found[0] == pytest.approx(expected[place][0], abs=2e-2), place


@pytest.mark.slow
@pytest.mark.parametrize("x", [0, -3, -8])
@pytest.mark.parametrize("make", [open_seam, split_faces])
def test_grab_goes_over_merged_seams_as_if_they_were_joined(make, x):
    def grabbed(obj):
        options = {"size": 0.3, "offset": (0.0, 0.0, 2.0)}
        assert bpy.ops.meanvalue.grab(vertex=int(at(obj, x, 8)[0]), **options) == {'FINISHED'}
        handles.update()
        return obj

    expected = lifts(grabbed(joined()))
    assert sum(0.1 < each[0] < 1.9 for each in expected.values()) > 50
    obj = grabbed(make())
    assert_lifted_alike(obj, expected)
    for place in expected:
        assert np.ptp(region_weights(obj)[at(obj, *place)]) < 1e-6


def test_a_wing_whose_corners_are_inside_its_body_stays_on_it():
    vertices, faces = [(x, y, height(x, y)) for y in range(9) for x in range(-4, 5)], meshes.grid_faces(9, 9)
    roots = [3 * 9 + 4, 4 * 9 + 4, 5 * 9 + 4]
    wing = [tuple(np.add(vertices[root], (0.0, 0.0, z))) for z in range(7) for root in roots]
    wing_faces = [tuple(81 + each for each in face) for face in meshes.grid_faces(3, 7)]
    obj = meshes.make_object(vertices + wing, faces + wing_faces, "Winged")
    assert bpy.ops.meanvalue.grab(vertex=len(vertices) + 19, size=1.5, offset=(2.0, 0.0, 0.0)) == {'FINISHED'}
    handles.update()
    moves = shown(obj) - rest(obj)
    assert moves[100, 0] == pytest.approx(2.0, abs=1e-3) and np.linalg.norm(moves[roots], axis=1).max() > 0.05
    assert np.array_equal(moves[81:84], moves[roots])


@pytest.mark.parametrize("make", [open_seam, split_faces])
def test_symmetric_and_merged_is_as_symmetric_and_joined(make):
    def grabbed(obj):
        obj.meanvalue.symmetric = 'X'
        options = {"size": 0.2, "offset": (0.0, 0.0, 2.0)}
        assert bpy.ops.meanvalue.grab(vertex=int(at(obj, -5, 8)[0]), **options) == {'FINISHED'}
        handles.update()
        return obj

    expected = lifts(grabbed(joined()))
    assert expected[(5, 8)][0] == pytest.approx(2.0, abs=1e-3) and 0.1 < expected[(0, 8)][0] < 1.9
    assert_lifted_alike(grabbed(make()), expected)


def test_a_region_grows_over_merged_seams():
    def grown(obj):
        steps.add_handle(obj, "Handle", at(obj, -2, 8).tolist()[:1], live=False)
        steps.run(obj, "grow_region", distance=5.2)
        return {tuple(each) for each in np.round(positions(obj)[region_weights(obj) > 0.0, :2]).astype(int)}

    assert grown(joined()) == grown(open_seam()) == grown(split_faces())


def bound(obj, seam_rows, region, is_soft=False):
    """(object, control): the left border pinned, a handle on the left copies of the seam, a region."""
    steps.add_group(obj, "Pin", over(obj, lambda x, y: x == -SIDE))
    steps.add_group(obj, "Handle", [int(at(obj, 0, y)[0]) for y in seam_rows])
    steps.add_group(obj, "Region", region)
    assert bpy.ops.meanvalue.add_handle(pin=True, group="Pin") == {'FINISHED'}
    assert bpy.ops.meanvalue.add_handle(group="Handle", live=False) == {'FINISHED'}
    control = bpy.context.object
    meshes.activate(obj)
    obj.meanvalue.roi_group = "Region"
    obj.meanvalue.handles["Handle"].is_soft = is_soft
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    return obj, control


def lifted(obj, control):
    handles.move(control, (0.0, 0.0, 1.0))
    steps.solve()
    return lifts(obj)


LEFT = range((SIDE + 1) ** 2)  #: of open_seam()


@pytest.mark.parametrize("is_soft", [False, True])
def test_what_is_in_the_region_on_one_side_of_a_seam_is_on_both(is_soft):
    obj, control = bound(open_seam(), (6, 7, 8), LEFT, is_soft)
    for place, found in lifted(obj, control).items():
        assert np.ptp(found) < 1e-5, place
        assert (max(found) > 0.02) <= (place[0] <= 0), place
    assert lifts(obj)[(0, 7)][0] > (0.05 if is_soft else 0.99)
    assert lifts(obj)[(0, 12)][0] > 1e-3  # the seam itself is free


def test_a_handle_outside_the_region_takes_its_doubles_along():
    obj = open_seam()
    obj, control = bound(obj, (6, 7, 8), over(obj, lambda x, y: x < -2))
    found = lifted(obj, control)
    assert np.allclose(found[(0, 7)], 1.0, atol=1e-5)
    assert found[(0, 12)] == [0.0, 0.0]


def test_a_handle_is_found_on_all_copies():
    obj = open_seam()
    left, right = (int(each) for each in at(obj, 0, 8))
    steps.add_handle(obj, "Handle", [left], size=0.3)
    steps.run(obj, "grab", vertex=right, offset=(0.0, 0.0, 1.0))
    handles.update()
    assert [handle.name for handle in obj.meanvalue.handles] == ["Handle"]
    assert np.allclose(lifts(obj)[(0, 8)], 1.0, atol=1e-4)


@pytest.mark.parametrize("is_turned", [False, True])
def test_two_layers_in_one_place_are_grabbed_as_one(is_turned):
    tube = meshes.tube(17, 8).data
    points = [tuple(each.co) for each in tube.vertices]
    faces = [tuple(each.vertices) for each in tube.polygons if len(each.vertices) == 4]  # open ends, as clothes have
    other = [tuple(len(points) + each for each in face[:: -1 if is_turned else 1]) for face in faces]
    obj = meshes.make_object(points + points, faces + other, "Layers")
    meshes.activate(obj)
    bpy.ops.meanvalue.grab(vertex=len(points) - 4, offset=(2.0, 0.0, 0.5), size=0.4)
    moves = (shown(obj) - rest(obj)).reshape(2, -1, 3)
    assert moves.max() > 1.9 and np.abs(moves[0] - moves[1]).max() < 1e-5


# -- what is told of it


@pytest.mark.parametrize("jitter", [5e-5, 1e-3])
def test_corners_that_are_nearly_in_one_place_are_told_with_a_distance_that_joins_them(jitter, capfd):
    vertices, faces = meshes.split([(x, y, 0.0) for y in range(9) for x in range(9)], meshes.grid_faces(9, 9))
    obj = meshes.make_object(vertices + np.random.default_rng(1).uniform(-jitter, jitter, (len(vertices), 3)), faces)
    meshes.activate(obj)
    bpy.ops.meanvalue.grab(vertex=130, offset=(0.0, 0.0, 1.0), size=0.4)
    handles.update()
    told = [capfd.readouterr().out, installed.part("live.engine").status(obj)[0]]
    meshes.activate(obj)
    bpy.ops.meanvalue.select_problems(kind='GAP')
    told.append(capfd.readouterr().out)
    bpy.ops.object.mode_set(mode='OBJECT')
    names = r"252 vertices .*Merge Distance (?:to )?([-.e0-9]*[0-9])"
    distances = [re.search(names, each)[1] for each in told]
    assert distances == distances[:1] * 3 and 2.0 * jitter < float(distances[0]) < 10.0 * jitter
    obj.meanvalue.merge_distance = float(distances[0])
    handles.update()
    assert meshes.gap(obj) < 10.0 * jitter
    assert np.count_nonzero((shown(obj) - rest(obj))[:, 2] > 0.05) > 40
    assert installed.part("live.engine").status(obj) is None


def test_merged_doubles_are_no_problem_any_more(capfd):
    obj = open_seam()
    steps.add_handle(obj, "Pin", over(obj, lambda x, y: x == -SIDE), pin=True)
    steps.add_handle(obj, "Handle", over(obj, lambda x, y: x == SIDE), live=False)
    for is_on, distance, is_told in ((True, 0.0, False), (False, 0.0, True), (False, 1e-3, False)):
        meshes.activate(obj)
        obj.meanvalue.close_seams, obj.meanvalue.merge_distance = is_on, distance
        assert bpy.ops.meanvalue.select_problems(kind='DOUBLE') == {'FINISHED'}
        assert ("Doubles (32)" in capfd.readouterr().out) == is_told
        assert (obj.mode == 'EDIT') == is_told
        bpy.ops.object.mode_set(mode='OBJECT')
