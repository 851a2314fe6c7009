# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: rings of skin that go along with limbs, on the generated figure; without Blender."""

import numpy as np
import pytest

from addon.capture.core import landmarks, marker_sets, soles
from addon.capture.core.matching import match_to_surface
from addon.capture.core.proportions import hips_of, with_hips
from addon.scene.surface import Surface
from blender_tests.support import body_mesh, walking_figure

VERTICES, TRIANGLES, BONES = body_mesh.body()
SURFACE = Surface(VERTICES, TRIANGLES)
REFERENCE = walking_figure.t_pose().clean[0]
UP = np.array([0.0, 0.0, 1.0])
NAMES = marker_sets.recognise(walking_figure.LABELS).landmarks
ANCHORS = match_to_surface(REFERENCE, SURFACE).vertex
LEGS = [f"{bone}.{side}" for bone in ("shank", "thigh") for side in "LR"]


def found(markers, names=NAMES):
    return soles.find_cuffs(markers, REFERENCE, names, ANCHORS, SURFACE)


def places(cuff):
    """(f, k, 3): where the cuff's vertices go."""
    return cuff.centres[:, None] + np.einsum("fij,kj->fki", cuff.turns, VERTICES[cuff.vertices] - cuff.centre)


@pytest.mark.parametrize("size", [1.0, 1000.0])
def test_a_cuff_goes_around_its_limb_in_any_unit(size):
    angles = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = size * np.stack([np.cos(angles), np.sin(angles), np.zeros(24)], axis=1)
    assert set(soles.spread(ring, ring[:0], 4)) == {0, 6, 12, 18}


def test_shanks_of_a_walk_get_cuffs_that_move_with_the_bone():
    joints, turns, _ = walking_figure.walking(np.arange(120) / 100.0)
    walk = walking_figure.markers_on(joints, turns)
    rest, _ = walking_figure.upright(1, 1.0)
    by_name = {cuff.segment: cuff for cuff in found(walk)}
    assert set(by_name) == set(LEGS)
    for side in "LR":
        cuff = by_name[f"shank.{side}"]
        assert cuff.strength > by_name[f"thigh.{side}"].strength > 0.8, "0.65 with hips by the pelvis alone"
        assert set(BONES[cuff.vertices]) == {f"shank.{side}"}
        assert len(set(cuff.vertices)) == 6 and not set(cuff.vertices) & set(ANCHORS)
        local = VERTICES[cuff.vertices] - rest[f"knee.{side}"][0]
        truth = joints[f"knee.{side}"][:, None] + np.einsum("fij,kj->fki", turns[f"shank.{side}"], local)
        assert np.linalg.norm(places(cuff) - truth, axis=2).max() < 1e-3, "the knee's marker goes with the thigh"
        thigh, axis = by_name[f"thigh.{side}"], turns[f"thigh.{side}"][..., 2]
        along = np.einsum("fi,fi->f", thigh.centres - joints[f"hip.{side}"], axis)
        assert np.abs(along - thigh.centre[2] + rest[f"hip.{side}"][0, 2]).max() < 0.001, "0.015 by where hips are told"
        shank = [k for k, name in enumerate(NAMES) if f"shank.{side}" in landmarks.segments_of(name)]
        away = VERTICES[[*ANCHORS[shank], *cuff.vertices]] - soles.ring_around(cuff.centre, UP, VERTICES, TRIANGLES)[1]
        angles = np.sort(np.arctan2(*away[:, :2].T))
        assert np.diff(np.append(angles, angles[0] + 2.0 * np.pi)).max() < 0.6 * np.pi, "all round"


@pytest.mark.parametrize("slides", [0.0, 0.004])
def test_hips_are_where_thighs_turn_about_as_far_as_skin_lets_see(slides):
    joints, turns, _ = walking_figure.walking(np.arange(200) / 100.0)
    walk, rest = walking_figure.markers_on(joints, turns), walking_figure.upright(1, 1.0)[0]
    bell = hips_of(REFERENCE, NAMES)
    for side in "LR":  # up and down as the knee goes a little sideways
        thigh = [k for k, name in enumerate(NAMES) if name in (f"thigh.{side}", f"knee.{side}")]
        aside = np.einsum("fi,fi->f", turns["pelvis"][..., 0], turns[f"thigh.{side}"][..., 2])
        walk[:, thigh, 2] += slides * (aside - aside.mean())[:, None] / aside.std()
    found, moved, names = with_hips(REFERENCE, walk, NAMES)
    assert names[-2:] == ("hip.L", "hip.R") and np.isfinite(moved).all()
    off = np.linalg.norm(found[-2:] - [rest["hip.L"][0], rest["hip.R"][0]], axis=1)
    if slides:
        assert off.max() < 0.06 and np.abs(found[-2:] - bell)[:, 0].max() < 0.02, "0.17 beside without doubt"
    else:
        assert off.max() < 0.002 < 0.05 < np.linalg.norm(bell[0] - rest["hip.L"][0])
    still = with_hips(REFERENCE, np.repeat(REFERENCE[None], 5, axis=0), NAMES)[0]
    assert np.abs(still[-2:] - bell).max() < 1e-6, "who does not move tells nothing"


def test_a_segment_whose_roll_its_markers_do_not_tell_gets_none():
    joints, turns, _ = walking_figure.walking(np.arange(120) / 100.0)
    line = {**walking_figure.SIDE_MARKERS, "KneeOut": ("thigh", (0.062, 0.0, -1.0)),
            "Shin": ("shank", (0.0535, 0.0025, -0.5))}  # fmt: skip
    walk = walking_figure.markers_on(joints, turns, sides=line)
    still = walking_figure.markers_on(*walking_figure.upright(1, 1.0), sides=line)[0]
    walk += 0.001 * np.random.default_rng(0).standard_normal(walk.shape)
    anchors = match_to_surface(still, SURFACE).vertex
    made = {cuff.segment for cuff in soles.find_cuffs(walk, still, NAMES, anchors, SURFACE)}
    assert made and not {"shank.L", "shank.R"} & made


def test_a_cuff_is_free_where_its_markers_are_away_and_nowhere_else():
    walk = walking_figure.take(120).clean
    shin = walking_figure.LABELS.index("LShin")
    walk[30:50, shin] = np.nan
    by_name = {cuff.segment: cuff for cuff in found(walk)}
    away = np.isnan(by_name["shank.L"].centres).any(axis=1)
    assert np.array_equal(np.flatnonzero(away), np.arange(30, 50))
    assert np.array_equal(away, np.isnan(by_name["shank.L"].turns).any(axis=(1, 2)))
    assert not np.isnan(by_name["shank.R"].centres).any()
