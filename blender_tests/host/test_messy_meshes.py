# SPDX-License-Identifier: GPL-3.0-or-later
"""Messy meshes are solved to finite shapes, what is healthy of them as without the mess; and all of it is told of."""

import numpy as np
import pytest

pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from addon.posing.core import mesh_problems
from addon.posing.core.bind_input import BindInput
from addon.scene.core import welding
from blender_tests.support import native_calls
from native.benchmarks.rigid import rotation_about


def given(vertices, triangles, anchors, pieces=None, **options):
    roi = options.pop("roi", None)
    rest = vertices.astype(np.float32)
    corners, starts = triangles.ravel().astype(np.int32), np.arange(0, triangles.size, 3, dtype=np.int32)
    ways = options.pop("close_seams", False), options.pop("merge_distance", 0.0)
    return BindInput(
        rest=rest,
        face_corners=corners,
        face_starts=starts,
        copies=welding.copies(rest, *ways, corners, starts),
        anchors=np.asarray(anchors, np.int32),
        roi=np.ones(len(vertices), bool) if roi is None else roi,
        method="fast",
        handles=np.zeros(len(anchors), np.int32) if pieces is None else np.asarray(pieces, np.int32),
        **{"rigidity": 15.0, **options},
    )


def solved(bind_input, triangles, targets, **options):
    """(n x 3, the Deformer), as session.solve_steps."""
    deformer = native_calls.bound(bind_input, triangles)
    whole = bind_input.solver_mesh
    return np.asarray(whole.cut_back(deformer.solve(whole.targets(targets), **options).vertices)), deformer


def tube():
    """An open tube along z from 0 to 6, radius 1: 16 rings of 12."""
    vertices, triangles = native_calls.tube(12, 16)
    return vertices * [1.0, 1.0, 0.8], triangles


def bent_tube(vertices, triangles, count, **options):
    """(n x 3, Deformer) of a tube of `count` vertices and whatever else, its ends turned by 40 degrees."""
    anchors = np.concatenate([np.arange(12), np.arange(count - 12, count)])
    bind_input = given(vertices, triangles, anchors, np.repeat([0, 1], 12), **options)
    targets = bind_input.anchor_rest.copy()
    targets[12:] = (targets[12:] - [0.0, 0.0, 6.0]) @ rotation_about((1, 0, 0), 40.0).T + [0.0, -1.5, 5.0]
    return solved(bind_input, triangles, targets)


def messes():
    """name: what makes vertices and triangles messy, and the kind of problem that it is told as."""
    row = 5 * 24  # a face in the middle

    def twice(vertices, triangles):
        return vertices, np.concatenate([triangles, triangles[row : row + 3]])

    def wire(vertices, triangles):
        return np.concatenate([vertices, vertices[60:63] * 1.5]), triangles

    def flat(vertices, triangles):
        middle = vertices[triangles[row, :2]].mean(axis=0)
        corner = len(vertices)
        return np.concatenate([vertices, [middle]]), np.concatenate(
            [triangles, [(triangles[row, 0], triangles[row, 1], corner)]]
        )

    def fin(vertices, triangles):
        corner = len(vertices)
        return np.concatenate([vertices, vertices[triangles[row, :1]] * [2.0, 2.0, 1.0]]), np.concatenate(
            [triangles, [(triangles[row, 0], triangles[row, 1], corner)]]
        )

    def copy(vertices, triangles):
        return np.concatenate([vertices, vertices]), np.concatenate([triangles, triangles + len(vertices)])

    return {
        "twice": (twice, 'FIN'),
        "wire": (wire, 'WIRE'),
        "flat": (flat, 'NO_AREA'),
        "fin": (fin, 'FIN'),
        "copy": (copy, 'DOUBLE'),
    }


@pytest.mark.parametrize("name", messes())
def test_the_healthy_part_is_as_without_the_mess(name):
    clean, faces = tube()
    expected, _ = bent_tube(clean, faces, len(clean))
    make, kind = messes()[name]
    vertices, triangles = make(clean, faces)
    triangles = triangles.astype(np.int32)
    result, deformer = bent_tube(vertices, triangles, len(clean))
    assert np.isfinite(result).all()
    assert np.abs(result[: len(clean)] - expected).max() < 0.03  # of a radius of 1: what is added has a shape as well
    assert kind in mesh_problems.find(vertices, triangles, deformer.report)[0]
    assert kind not in mesh_problems.find(clean, faces)[0]


def test_a_flipped_face_is_found_and_solved():
    vertices, triangles = tube()
    messy = triangles.copy()
    messy[100] = messy[100, ::-1]
    result, deformer = bent_tube(vertices, messy, len(vertices))
    expected, _ = bent_tube(vertices, triangles, len(vertices))
    assert np.abs(result - expected).max() < 0.05
    problems, _distance = mesh_problems.find(vertices, messy, deformer.report)
    assert set(messy[100]) == set(problems['FLIPPED'])
    assert deformer.report.detached_triangle_count == 1


def with_doubles(vertices, triangles, share, seed):
    """Every so many triangles get corners of their own: holes in the surface, and loose triangles in them."""
    chosen = np.random.default_rng(seed).random(len(triangles)) < share
    corners = triangles[chosen].ravel()
    result = triangles.copy()
    result[chosen] = (len(vertices) + np.arange(len(corners))).reshape(-1, 3)
    return np.concatenate([vertices, vertices[corners]]), result.astype(np.int32)


@pytest.mark.parametrize("seed", range(6))
def test_whatever_is_done_to_the_faces_the_shape_is_finite(seed):
    random = np.random.default_rng(seed)
    vertices, triangles = tube()
    count = len(vertices)
    some = [random.random(len(triangles)) < 0.08 for _ in range(3)]
    messy = triangles.copy()
    messy[some[0]] = messy[some[0], ::-1]
    messy = np.concatenate([messy[~some[1]], messy[some[2]]])
    vertices, messy = with_doubles(vertices, messy, 0.1, seed)
    vertices[random.integers(24, count - 24, 5)] = vertices[40]  # faces without area
    result, deformer = bent_tube(vertices, messy.astype(np.int32), count)
    assert np.isfinite(result).all()
    assert np.linalg.norm(result - vertices, axis=1).max() < 20.0
    found, _distance = mesh_problems.find(vertices, messy, deformer.report)
    assert {'DOUBLE', 'NO_AREA', 'FLIPPED'} <= found.keys()
    for each in found.values():
        assert each.min() >= 0 and each.max() < len(vertices)
        assert (np.diff(each) > 0).all()


@pytest.mark.parametrize("is_merged", [False, True])
def test_a_mesh_that_cannot_be_coarsened(is_merged):
    """Every face there from both sides: no edge of it fits a manifold; in pieces of one face, or in one place."""
    vertices, triangles = tube()
    triangles = np.concatenate([triangles, triangles[:, ::-1]])
    options = {}
    if not is_merged:
        count = len(vertices)
        vertices = np.concatenate([vertices, vertices[triangles[400:]].reshape(-1, 3)])
        triangles[400:] = count + np.arange(3 * (len(triangles) - 400)).reshape(-1, 3)
    else:
        options["merge_distance"] = 1e-6
    result, deformer = bent_tube(vertices, triangles.astype(np.int32), 192, **options)
    assert np.isfinite(result).all()
    assert np.linalg.norm(result - vertices, axis=1).max() < 8.0
    assert deformer.report.detached_triangle_count >= 40
    assert 'FIN' in mesh_problems.find(vertices, triangles)[0]


def test_a_clean_mesh_has_no_problems():
    assert mesh_problems.find(*tube())[0] == {}


def test_numbers_of_32_bits_are_enough_for_large_meshes(monkeypatch):
    """As numpy has them on Windows: products of two numbers of vertices are larger."""
    find = mesh_problems.welding.first_of_place
    monkeypatch.setattr(mesh_problems.welding, "first_of_place", lambda *given: find(*given).astype(np.int32))
    points = np.random.default_rng(3).uniform(size=(60000, 3))
    points[-1] = points[-2]
    triangles = np.arange(60000, dtype=np.int32).reshape(-1, 3)
    places = np.arange(60000, dtype=np.int32)
    problems, _distance = mesh_problems.find(points, triangles, places=places)
    assert list(problems['DOUBLE']) == [59998, 59999]
