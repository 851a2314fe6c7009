# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: rings of skin that go along with limbs, on the generated figure; without Blender."""

from types import SimpleNamespace

import numpy as np

from addon.capture.bridge import marker_cuffs
from addon.capture.core import cuffs, marker_sets
from addon.capture.core.matching import match_to_surface
from addon.capture.core.rings import ring_around
from blender_tests.support import body_mesh, walking_figure

VERTICES, TRIANGLES, BONES = body_mesh.body()
REFERENCE = walking_figure.t_pose().clean[0]
NOTHING, UP = np.zeros((0, 3)), np.array([0.0, 0.0, 1.0])
NAMES = marker_sets.recognise(walking_figure.LABELS).landmarks
ANCHORS = match_to_surface(REFERENCE, VERTICES, TRIANGLES).vertex
LEGS = [f"{bone}.{side}" for bone in ("shank", "thigh") for side in "LR"]


def found(markers, names=NAMES):
    return cuffs.find_cuffs(markers, REFERENCE, names, ANCHORS, VERTICES, TRIANGLES)


def places(cuff):
    """(f, k, 3): where the cuff's vertices go."""
    return cuff.centres[:, None] + np.einsum("fij,kj->fki", cuff.turns, VERTICES[cuff.vertices] - cuff.centre)


def test_shanks_of_a_walk_get_cuffs_that_move_with_the_bone():
    joints, turns, _ = walking_figure.walking(np.arange(120) / 100.0)
    walk = walking_figure.markers_on(joints, turns)
    rest, _ = walking_figure.upright(1, 1.0)
    by_name = {cuff.segment: cuff for cuff in found(walk)[0]}
    assert {"shank.L", "shank.R"} <= set(by_name) <= set(LEGS)
    for side in "LR":
        cuff = by_name[f"shank.{side}"]
        assert set(BONES[cuff.vertices]) == {f"shank.{side}"}
        assert len(set(cuff.vertices)) == 3 and not set(cuff.vertices) & set(ANCHORS)
        local = VERTICES[cuff.vertices] - rest[f"knee.{side}"][0]
        truth = joints[f"knee.{side}"][:, None] + np.einsum("fij,kj->fki", turns[f"shank.{side}"], local)
        assert np.linalg.norm(places(cuff) - truth, axis=2).max() < 1e-3, "the knee's marker goes with the thigh"
        held = VERTICES[[*ANCHORS[list(cuff.markers)], *cuff.vertices]]
        assert ring_around(cuff.centre, UP, VERTICES, TRIANGLES, held).bare < 0.6 * np.pi


def test_a_segment_whose_roll_its_markers_do_not_tell_gets_none():
    joints, turns, _ = walking_figure.walking(np.arange(120) / 100.0)
    line = {**walking_figure.SIDE_MARKERS, "KneeOut": ("thigh", (0.062, 0.0, -1.0)),
            "Shin": ("shank", (0.0535, 0.0025, -0.5))}  # fmt: skip
    walk = walking_figure.markers_on(joints, turns, sides=line)
    still = walking_figure.markers_on(*walking_figure.upright(1, 1.0), sides=line)[0]
    walk += 0.001 * np.random.default_rng(0).standard_normal(walk.shape)
    anchors = match_to_surface(still, VERTICES, TRIANGLES).vertex
    made, refused = cuffs.find_cuffs(walk, still, NAMES, anchors, VERTICES, TRIANGLES)
    assert not {"shank.L", "shank.R"} & {cuff.segment for cuff in made}
    assert min(refused[name] for name in ("shank.L", "shank.R")) > cuffs.ROLL


def test_a_cuff_is_free_where_its_markers_are_away_and_nowhere_else():
    walk = walking_figure.take(120).clean
    shin = walking_figure.LABELS.index("LShin")
    walk[30:50, shin] = np.nan
    by_name = {cuff.segment: cuff for cuff in found(walk)[0]}
    away = np.isnan(by_name["shank.L"].centres).any(axis=1)
    assert np.array_equal(np.flatnonzero(away), np.arange(30, 50))
    assert np.array_equal(away, np.isnan(by_name["shank.L"].turns).any(axis=(1, 2)))
    assert not np.isnan(by_name["shank.R"].centres).any()


def test_without_names_what_is_stiff_is_found_from_the_capture():
    """Three markers on a rod, three on another one that swings about its end, one that wanders."""
    rng = np.random.default_rng(3)
    angles = 0.8 * np.sin(np.linspace(0.0, 6.0, 200))
    rod = np.array([[0.05, 0.0, -0.1], [0.0, 0.05, -0.25], [0.05, 0.0, -0.4]])
    upper, lower = rod + np.array([0.0, 0.0, 0.95]), rod + np.array([0.0, 0.0, 0.45])
    pivot = np.array([0.0, 0.0, 0.45])
    swung = np.einsum("fij,kj->fki", walking_figure.turn_x(angles), lower - pivot) + pivot
    wander = np.cumsum(0.02 * rng.standard_normal((200, 1, 3)), axis=0) + np.array([0.3, 0.0, 0.5])
    markers = np.concatenate([np.broadcast_to(upper, (200, 3, 3)), swung, wander], axis=1)
    markers = markers + 0.0005 * rng.standard_normal(markers.shape)
    reference = np.concatenate([upper, lower, [[0.3, 0.0, 0.5]]])
    vertices, triangles = body_mesh.capsule(np.zeros(3), np.array([0.0, 0.0, 0.95]), (0.05, 0.05), 24, 40)
    anchors = match_to_surface(reference, vertices, triangles).vertex
    made, refused = cuffs.find_cuffs(markers, reference, (None,) * 7, anchors, vertices, triangles)
    assert sorted(cuff.markers for cuff in made) == [(0, 1, 2), (3, 4, 5)] and not refused
    moving = next(cuff for cuff in made if cuff.markers == (3, 4, 5))
    truth = np.einsum("fij,j->fi", walking_figure.turn_x(angles), moving.centre - pivot) + pivot
    assert np.linalg.norm(moving.centres - truth, axis=1).max() < 0.003


def test_markers_all_round_need_no_cuff():
    walk = walking_figure.take(60).clean
    names = list(NAMES)
    height = REFERENCE[walking_figure.LABELS.index("LShin"), 2]
    ring = ring_around(np.array([0.09, 0.0, height]), UP, VERTICES, TRIANGLES, NOTHING)
    more = ring.spread(4, set())
    joints, turns, _ = walking_figure.walking(np.arange(60) / 100.0)
    rest, _ = walking_figure.upright(1, 1.0)
    local = VERTICES[more] - rest["knee.L"][0]
    carried = joints["knee.L"][:, None] + np.einsum("fij,kj->fki", turns["shank.L"], local)
    made, _ = cuffs.find_cuffs(
        np.concatenate([walk, carried], axis=1), np.concatenate([REFERENCE, VERTICES[more]]),
        (*names, *(f"shank.{number}.L" for number in range(2, 6))), np.append(ANCHORS, more), VERTICES, TRIANGLES,
    )  # fmt: skip
    segments = {cuff.segment for cuff in made}
    assert "shank.L" not in segments and "shank.R" in segments


def test_cuffs_that_begin_with_the_same_marker_have_names_of_their_own():
    """Of a rod with a hinge in its middle, whose marker belongs to both halves."""
    rest = np.array([[0.0, 0.05, 0.9], [0.05, 0.0, 0.75], [0.0, 0.05, 0.6]])
    rest = np.concatenate([[[0.05, 0.0, 0.47]], rest, rest - [0.0, 0.0, 0.55]])
    turns, pivot = walking_figure.turn_x(0.8 * np.sin(np.linspace(0.0, 6.0, 200))), np.array([0.05, 0.0, 0.47])
    markers = np.repeat(rest[None], 200, axis=0)
    markers[:, 4:] = np.einsum("fij,kj->fki", turns, rest[4:] - pivot) + pivot
    vertices, triangles = body_mesh.capsule(np.zeros(3), np.array([0.0, 0.0, 0.95]), (0.05, 0.05), 24, 40)
    surface = SimpleNamespace(vertices=vertices, triangles=triangles, to_world=np.eye(4))
    labels = [f"M{number}" for number in range(7)]
    given = SimpleNamespace(use_cuffs=True, surface=surface)
    aligned = SimpleNamespace(path=markers, reference=rest, landmarks=(None,) * 7, labels=labels)
    made, _ = marker_cuffs.find(given, aligned, match_to_surface(rest, vertices, triangles))
    assert [cuff.name for cuff in made] == ["M0 cuff", "M0 cuff 2"]
