# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/: plain Python, run without Blender."""

import itertools
import pathlib
import sys
import types

import numpy as np
import pytest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from addon import wording
from addon.errors import SceneError
from addon.posing.core import springs
from addon.posing.core.bind_input import BindInput, anchor_layout, region_weights
from addon.scene.core import fixed_points, motion
from addon.scene.core.finite import require_finite
from addon.solver.core import fingerprint, result
from addon.solver.core.deformer_cache import DeformerCache
from addon.solver.core.fingerprint import StaleReason


def test_core_does_not_need_blender():
    assert "bpy" not in sys.modules


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
    assert square().fingerprint.key == square().fingerprint.key


def changed(name, index, value):
    array = getattr(square(), name).copy()
    array[index] = value
    return square(**{name: array})


@pytest.mark.parametrize(
    "after, reasons",
    [
        (changed("rest", (4, 2), np.nextafter(np.float32(0.1), np.float32(1.0))), [StaleReason.REST_SHAPE]),
        (changed("face_corners", 0, 8), [StaleReason.FACES]),
        (square(face_starts=np.array([0, 4, 8], np.int32)), [StaleReason.FACES]),
        (changed("anchors", 2, 8), [StaleReason.ANCHORS]),
        (square(anchors=np.array([0, 2, 6, 8], np.int32)), [StaleReason.ANCHORS]),
        (changed("roi", 7, False), [StaleReason.ROI]),
        (square(method="fast"), [StaleReason.SETTINGS]),
        (square(rest=np.zeros((10, 3), np.float32), roi=np.ones(10, bool)), [StaleReason.VERTICES]),
    ],
)
def test_each_change_has_its_reason(after, reasons):
    assert list(fingerprint.stale_reasons(square().fingerprint, after.fingerprint)) == reasons


def test_several_reasons_at_once():
    after = square(anchors=np.array([1, 2, 6], np.int32), method="fast")
    reasons = fingerprint.stale_reasons(square().fingerprint, after.fingerprint)
    assert reasons == (StaleReason.ANCHORS, StaleReason.SETTINGS)
    text = fingerprint.describe(reasons, square().fingerprint, after.fingerprint)
    assert text == "the handles changed and the settings changed"


@pytest.mark.parametrize("reason", list(StaleReason))
def test_only_changes_of_the_mesh_need_the_artist(reason):
    mesh_changes = {StaleReason.VERTICES, StaleReason.FACES, StaleReason.REST_SHAPE}
    assert fingerprint.needs_bind((reason,)) == (reason in mesh_changes)


def test_both_counts_are_told():
    after = square(
        rest=np.zeros((1200, 3), np.float32), face_starts=np.arange(3, dtype=np.int32), roi=np.ones(1200, bool)
    )
    bound, now = square().fingerprint, after.fingerprint
    reasons = fingerprint.stale_reasons(bound, now)
    assert reasons == (StaleReason.VERTICES, StaleReason.FACES)
    text = fingerprint.describe(reasons, bound, now)
    assert text == "the mesh has 1,200 vertices (9 when bound) and 3 faces (4 when bound)"


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


def test_digest_does_not_care_about_memory_layout():
    values = np.arange(12, dtype=np.float32).reshape(4, 3)
    assert fingerprint.digest(values) == fingerprint.digest(np.asfortranarray(values))


# -- what can be bound -----------------------------------------------------------------------------------------------


def test_a_good_input_passes():
    square().check()


def test_free_are_the_region_without_anchors():
    roi = np.zeros(9, bool)
    roi[[0, 4, 5]] = True
    assert np.flatnonzero(square(roi=roi).free).tolist() == [4, 5]


@pytest.mark.parametrize(
    "broken, text",
    [
        (square(face_starts=np.empty(0, np.int32), face_corners=np.empty(0, np.int32)), "has no faces"),
        (changed("rest", (5, 1), np.nan), "the first is 5"),
        (square(anchors=np.arange(9, dtype=np.int32)), "Nothing is free"),
        (square(anchors=np.array([0, 8], np.int32)), "2 fixed points cannot hold"),
        (square(anchors=np.array([0, 1, 2], np.int32)), "not in one line"),
    ],
)
def test_each_refusal_says_why(broken, text):
    with pytest.raises(SceneError, match=text):
        broken.check()


def test_vertices_outside_the_region_hold_the_mesh_too():
    roi = np.zeros(9, bool)
    roi[4] = True
    square(anchors=np.array([0], np.int32), roi=roi).check()


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_every_kind_of_bad_number_is_found(value):
    positions = np.zeros((5, 3), np.float32)
    require_finite(positions, "thing")
    positions[3, 2] = value
    with pytest.raises(SceneError, match=r"1 vertex of the thing .the first is 3. has"):
        require_finite(positions, "thing")


def test_anchors_are_sorted_and_belong_to_the_first_group_that_has_them():
    union, pieces = anchor_layout([np.array([5, 1], np.int32), np.array([1, 3], np.int32), np.empty(0, np.int32)])
    assert pieces.tolist() == [0, 1, 0]
    assert pieces.dtype == np.int32
    assert union.tolist() == [1, 3, 5]
    assert union.dtype == np.int32


def test_region_masks():
    for invert in (False, True):
        assert region_weights(3, None, np.empty(0), invert).tolist() == [1.0] * 3
    assert region_weights(3, np.array([1]), np.array([0.25]), False).tolist() == [0.0, 0.25, 0.0]
    assert region_weights(3, np.array([1]), np.array([0.25]), True).tolist() == [1.0, 0.75, 1.0]


# -- fixed points ----------------------------------------------------------------------------------------------------


def similarity(points, scale, offset):
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    rotation = np.eye(3) + np.sin(1.1) * cross + (1 - np.cos(1.1)) * cross @ cross
    return (scale * points @ rotation.T + offset).astype(np.float32)


TRIANGLE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.2, 0.0)])
LINE = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.9, 0.0, 0.0)])


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("points, spans", [(TRIANGLE, True), (LINE, False), (LINE[:2], False), (LINE[:0], False)])
def test_plane_or_line_wherever_and_however_large(scale, points, spans):
    for order in itertools.permutations(range(len(points))):
        assert fixed_points.span_a_plane(similarity(points[list(order)], scale, 2.0 * scale)) == spans


def test_coincident_points_do_not_count():
    points = np.array([(1, 2, 3), (1, 2, 3), (4, 5, 6), (4, 5, 6)], np.float32)
    assert not fixed_points.span_a_plane(points)
    assert not fixed_points.span_a_plane(np.ones((9, 3), np.float32))


def test_diagonal():
    assert fixed_points.bounding_box_diagonal(np.array([(1, 1, 1), (2, 3, 3)], np.float32)) == 3.0
    assert fixed_points.bounding_box_diagonal(np.empty((0, 3), np.float32)) == 0.0


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
        vertex_count=40,
        anchor_count=3,
        free_count=30,
        guarded=np.array([4, 5, 9]),
        guarded_by_reason={"extended ring": np.array([4, 9]), "on ring edge": np.array([5])},
        components=components,
        carriers=[carrier[0] if carrier else -1 for _free, _left, *carrier in parts],
        timings={"encode": 0.05, "factor": 0.2},
    )


def test_parts_that_are_not_held():
    summary = result.BindSummary.of(report((10, 0), (5, 4), (0, 7), (5, 1)))
    assert (summary.unheld_part_count, summary.seconds) == (2, 0.25)
    assert "2 parts of the mesh have fewer than three fixed points" in next(iter(summary.notes()))
    following = result.BindSummary.of(report((10, 0), (5, 7, 0), (6, 7, 0), (5, 4)))
    assert (following.unheld_part_count, following.following_part_count) == (1, 2)
    assert following.text().endswith(", 2 loose parts follow")
    assert not result.nothing_is_held(report((10, 0), (5, 4)))
    assert result.nothing_is_held(report((10, 1), (5, 4), (0, 0)))
    assert list(result.BindSummary.of(report((10, 0), (0, 7))).notes()) == []


def test_fallback_rules_are_told():
    told = list(result.guarded_notes(report((10, 0)), np.arange(40)))
    assert told == ["3 vertices encoded by a fallback rule (extended ring: 2, on ring edge: 1)"]
    # Of mirror images nothing is told.
    told = list(result.guarded_notes(report((10, 0)), np.arange(5)))
    assert told == ["1 vertex encoded by a fallback rule (extended ring: 1)"]
    assert list(result.guarded_notes(report((10, 0)), np.arange(4))) == []


def test_only_a_large_binding_warns_of_a_long_solve():
    assert list(result.size_notes(types.SimpleNamespace(free_count=50_000))) == []
    (note,) = result.size_notes(types.SimpleNamespace(free_count=950_000))
    assert "950,000 free vertices" in note
    assert "smaller region" in note


def test_energy_for_diagonal_one():
    solution = types.SimpleNamespace(
        energy=8.0, iterations=3, converged=False, stop_reason="iteration limit", timings={"total": 0.01}
    )
    summary = result.SolveSummary.of(solution, 2.0)
    assert summary.energy == 2.0
    assert "iteration limit" in next(iter(summary.notes()))
    assert summary.text() == "3 iterations, energy 2, 10 ms"


# -- cache -----------------------------------------------------------------------------------------------------------


def test_the_least_recently_used_goes_first():
    cache = DeformerCache(capacity=2, byte_limit=100)
    cache.put("a", 1, 10)
    cache.put("b", 2, 10)
    assert cache.get("a") == 1
    cache.put("c", 3, 10)
    assert [cache.get(key) for key in "abc"] == [1, None, 3]


def test_bytes_are_limited_but_the_newest_stays():
    cache = DeformerCache(capacity=9, byte_limit=100)
    cache.put("a", 1, 60)
    cache.put("b", 2, 60)
    assert [cache.get(key) for key in "ab"] == [None, 2]
    cache.put("c", 3, 500)
    assert [cache.get(key) for key in "bc"] == [None, 3]
    assert len(cache) == 1


def test_the_newest_of_a_family_is_found_and_stays_as_old_as_it_is():
    cache = DeformerCache(capacity=3, byte_limit=100)
    cache.put("a", 1, 10, family="mesh")
    cache.put("b", 2, 10, family="mesh")
    cache.put("c", 3, 10, family="other")
    assert cache.relative("mesh") == 2
    assert cache.relative("none") is None
    cache.put("d", 4, 10)
    assert cache.get("a") is None
    assert cache.relative("mesh") == 2


def test_discard_and_clear():
    cache = DeformerCache(capacity=9, byte_limit=100)
    cache.put("a", 1, 1)
    cache.discard("a")
    cache.discard("never there")
    assert cache.get("a") is None
    cache.put("b", 1, 1)
    cache.clear()
    assert len(cache) == 0


# -- wording ---------------------------------------------------------------------------------------------------------


def test_wording():
    assert wording.vertices(1) == "1 vertex"
    assert wording.vertices(12345) == "12,345 vertices"
    assert wording.listed(["a", "b", "c"]) == "a, b and c"
    assert wording.quoted(["a", "b", "c", "d", "e"]) == "'a', 'b', 'c' and 2 more"
    assert wording.sentence("say it.") == wording.sentence("say it") == "Say it."
    told = [wording.seconds(value) for value in (0.0004, 0.0347, 2.309, 140.2)]
    assert told == ["0.4 ms", "35 ms", "2.31 s", "140 s"]


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


def test_a_pose_of_moved_anchors_in_the_region_needs_no_warning():
    assert list(result.pose_warnings(*posed_grid([1]))) == []


def test_a_pose_that_moves_no_anchor_is_told():
    (warning,) = result.pose_warnings(*posed_grid([]))
    assert warning.startswith("No handle has been moved")


def test_moved_anchors_outside_the_region_are_told():
    (warning,) = result.pose_warnings(*posed_grid([0, 1]))
    assert warning.startswith("1 vertex of moved handles outside the region")


# -- motion ----------------------------------------------------------------------------------------------------------


def a_move():
    """A turn by 50 degrees about (1, 2, 2), and a step."""
    x, y, z = np.array([1.0, 2.0, 2.0]) / 3.0
    cross = np.array([(0, -z, y), (z, 0, -x), (-y, x, 0)])
    angle = np.radians(50.0)
    move = np.eye(4)
    move[:3, :3] += np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross
    move[:3, 3] = (3.0, -1.0, 0.5)
    return move


def test_a_control_that_only_differs_by_noise_moves_nothing():
    relation = a_move()
    noisy = (relation.astype(np.float32) * np.float32(1.0 + 1e-7)).astype(np.float64)
    points = np.random.default_rng(1).normal(size=(5, 3)).astype(np.float32)
    moved = motion.apply(motion.between(relation, noisy), points)
    assert np.array_equal(moved, points.astype(np.float64))


def test_the_move_between_two_relations_takes_points_along():
    rest = a_move()
    points = np.random.default_rng(2).normal(size=(5, 3))
    move = motion.between(rest, a_move() @ rest)
    assert np.allclose(move, a_move(), atol=1e-12)
    assert np.allclose(motion.apply(move, points), points @ a_move()[:3, :3].T + a_move()[:3, 3])


def test_a_rigid_move_is_fitted_exactly():
    points = np.random.default_rng(3).normal(size=(6, 3))
    assert np.allclose(motion.fitted(points, motion.apply(a_move(), points)), a_move(), atol=1e-12)
    flat = points * (1.0, 1.0, 0.0)
    assert np.allclose(motion.fitted(flat, motion.apply(a_move(), flat)), a_move(), atol=1e-12)


@pytest.mark.parametrize("count", [1, 3])
def test_what_points_leave_open_is_not_turned(count):
    line = np.outer(np.arange(count), (1.0, 0.0, 0.0))
    move = motion.fitted(line, line + np.array((0.0, 2.0, 0.0)))
    assert np.allclose(move[:3, :3], np.eye(3))
    assert np.allclose(move[:3, 3], (0.0, 2.0, 0.0))


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
