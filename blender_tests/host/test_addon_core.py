# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/: plain Python, run without Blender."""

import types

import numpy as np
import pytest

from addon.errors import SceneError
from addon.posing.core import springs
from addon.posing.core.bind_input import BindInput, anchor_layout
from addon.scene.core.point_sets import require_finite
from addon.solver.core import fingerprint, result
from addon.solver.session import DeformerCache


def square(**changes):
    """Four quads in a 3 x 3 grid, corners anchored."""
    values = {
        "rest": np.array([(x, y, 0.1 * x * y) for y in range(3) for x in range(3)], np.float32),
        "face_corners": np.array([0, 1, 4, 3, 1, 2, 5, 4, 3, 4, 7, 6, 4, 5, 8, 7], np.int32),
        "face_starts": np.array([0, 4, 8, 12], np.int32),
        "anchors": np.array([0, 2, 6], np.int32),
        "roi": np.ones(9, bool),
        "method": "full",
        "handles": np.array([0, 0, 1], np.int32),
    }
    return BindInput(**{**values, **changes})


# -- fingerprint -----------------------------------------------------------------------------------------------------


def test_same_content_same_fingerprint():
    assert square().fingerprint == square().fingerprint


def changed(name, index, value):
    array = getattr(square(), name).copy()
    array[index] = value
    return square(**{name: array})


@pytest.mark.parametrize(
    "after, words",
    [
        (changed("rest", (4, 2), np.nextafter(np.float32(0.1), np.float32(1.0))), "the rest shape was edited"),
        (changed("face_corners", 0, 8), "the faces were changed"),
        (square(face_starts=np.array([0, 4, 8], np.int32)), "the faces were changed"),
        (changed("anchors", 2, 8), ""),
        (square(anchors=np.array([0, 2, 6, 8], np.int32)), ""),
        (changed("roi", 7, False), ""),
        (square(method="fast"), ""),
        (square(rest=np.zeros((10, 3), np.float32), roi=np.ones(10, bool)), "the mesh has 10 vertices (9 when bound)"),
    ],
)
def test_each_change_tells_and_the_artist_looks_at_those_of_the_mesh(after, words):
    assert square().fingerprint != after.fingerprint
    assert fingerprint.changes(square().fingerprint, after.fingerprint) == words
    assert fingerprint.changes(after.fingerprint, after.fingerprint) == ""


def test_digest_tells_shapes_types_and_order_apart():
    values = np.arange(6, dtype=np.int32)
    variants = [
        (values,),
        (values.reshape(2, 3),),
        (values.astype(np.int64),),
        (values[::-1],),
        (values[:3], values[3:]),
        (values[:2], values[2:]),
        ("012345",),
    ]
    digests = [fingerprint.digest(*parts) for parts in variants]
    assert len(set(digests)) == len(variants)


# -- what can be bound -----------------------------------------------------------------------------------------------


def test_free_are_the_region_without_anchors():
    roi = np.zeros(9, bool)
    roi[[0, 4, 5]] = True
    assert np.flatnonzero(square(roi=roi).free).tolist() == [4, 5]


def test_vertices_outside_the_region_hold_the_mesh_too():
    roi = np.zeros(9, bool)
    roi[4] = True
    square(anchors=np.array([0], np.int32), roi=roi).check()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_every_kind_of_bad_number_is_found(value):
    positions = np.zeros((5, 3), np.float32)
    require_finite(positions, "thing")
    positions[3, 2] = value
    with pytest.raises(SceneError, match=r"1 vertex of the thing .the first is 3."):
        require_finite(positions, "thing")


def test_anchors_are_sorted_and_belong_to_the_first_group_that_has_them():
    union, pieces = anchor_layout([np.array([5, 1], np.int32), np.array([1, 3], np.int32), np.empty(0, np.int32)])
    assert pieces.tolist() == [0, 1, 0]
    assert pieces.dtype == np.int32
    assert union.tolist() == [1, 3, 5]
    assert union.dtype == np.int32


# -- result ----------------------------------------------------------------------------------------------------------


def test_fixed_vertices_keep_their_bits():
    roi = np.ones(9, bool)
    roi[8] = False
    bind_input = square(roi=roi)
    pose = bind_input.rest + np.float32(1 / 3)
    solved = bind_input.rest.astype(np.float64) + 7.0
    positions = result.compose(bind_input, pose[bind_input.anchors], solved)
    assert positions.dtype == np.float32
    assert np.array_equal(positions[[0, 2, 6]], pose[[0, 2, 6]])
    assert np.array_equal(positions[8], bind_input.rest[8])
    free = [1, 3, 4, 5, 7]
    assert np.array_equal(positions[free], solved[free].astype(np.float32))


def report(*parts):
    components = [types.SimpleNamespace(free_count=free, undetermined=left) for free, left, *_carrier in parts]
    return types.SimpleNamespace(
        components=components,
        carriers=[carrier[0] if carrier else -1 for _free, _left, *carrier in parts],
        part_of=[*range(len(parts)), -1],
    )


def unheld(*parts):
    return list(result.unheld_notes(report(*parts), np.arange(len(parts) + 1)))


def test_parts_that_are_not_held():
    assert "2 parts of the mesh have fewer than three fixed points" in unheld((10, 0), (5, 4), (0, 7), (5, 1))[0]
    assert "1 part of the mesh has" in unheld((10, 0), (5, 7, 0), (6, 7, 0), (5, 4))[0]
    assert not result.nothing_is_held(report((10, 0), (5, 4)))
    assert result.nothing_is_held(report((10, 1), (5, 4), (0, 0)))
    assert unheld((10, 0), (0, 7)) == []


# -- cache -----------------------------------------------------------------------------------------------------------


def test_bytes_are_limited_but_the_newest_stays():
    cache = DeformerCache(capacity=9, byte_limit=100)
    cache.put("a", 1, 60)
    cache.put("b", 2, 60)
    assert [cache.get(key) for key in "ab"] == [None, 2]
    cache.put("c", 3, 500)
    assert [cache.get(key) for key in "bc"] == [None, 3]


# -- what a solve tells ------------------------------------------------------------------------------------------------


def posed_grid(moved):
    """Four vertices in a row: 0 and 1 anchors, 1 and 2 in the region; `moved` ones are moved in the pose."""
    rest = np.zeros((4, 3), np.float32)
    bind_input = BindInput(
        rest=rest,
        face_corners=np.arange(4, dtype=np.int32),
        face_starts=np.zeros(1, np.int32),
        anchors=np.array([0, 1], np.int32),
        roi=np.array([False, True, True, False]),
        method="full",
        handles=np.zeros(2, np.int32),
    )
    pose = rest.copy()
    pose[moved] += 1.0
    return bind_input, pose[bind_input.anchors]


@pytest.mark.parametrize(("moved", "warnings"), [([1], 0), ([], 1), ([0, 1], 1)])
def test_poses_that_move_no_handle_or_one_outside_the_region_are_told(moved, warnings):
    assert len(list(result.pose_warnings(*posed_grid(moved)))) == warnings


# -- springs ---------------------------------------------------------------------------------------------------------


def test_hard_handles_need_no_springs():
    assert springs.strengths(np.array([0, 1]), [None, None], 15.0, 100) is None


def test_a_spring_is_shared_out_among_the_vertices_of_its_handle():
    pieces = np.array([0, 1, 1, 2, 1, 1])
    strengths = springs.strengths(pieces, [None, 0.5, None], 15.0, 100)
    assert np.isinf(strengths[[0, 3]]).all()
    assert strengths[pieces == 1].sum() == pytest.approx(0.06)
    stronger = springs.strengths(pieces, [None, 0.75, None], 15.0, 100)
    assert (stronger[pieces == 1] > 5.0 * strengths[pieces == 1]).all()
    assert (springs.strengths(pieces, [None, 0.0, None], None, 100)[pieces == 1] > 0.0).all()


def test_soft_anchors_are_free_but_hold():
    soft = square(strengths=np.array([np.inf, 2.0, np.inf]))
    assert soft.free[2] and not soft.free[0]
    assert soft.is_held[[0, 2, 6]].all()
    assert soft.fingerprint.anchors != square().fingerprint.anchors
    soft.check()
