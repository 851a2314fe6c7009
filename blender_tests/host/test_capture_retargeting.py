# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: motion for other proportions, on a generated walk whose joints are known; without Blender."""

from types import SimpleNamespace

import numpy as np
import pytest

from addon.capture.core import landmarks, marker_sets
from addon.capture.core.body import Body
from addon.capture.core.matching import match_to_surface, retarget
from addon.capture.core.soles import find_stances, on_floor, standing
from addon.errors import InvalidMotionError
from addon.scene.core.motion import fit_rotations
from addon.scene.core.sample_times import runs
from addon.scene.surface import Surface
from blender_tests.support import body_mesh, walking_figure

LABELS = walking_figure.LABELS
NAMES = marker_sets.recognise(LABELS).landmarks
REFERENCE = walking_figure.t_pose().clean[0]
HEIGHT = walking_figure.HEIGHT


def at(label):
    return LABELS.index(label)


def knee_angles(positions, rest_figure, side):
    """(f,) degrees, of bones: thigh and shank turn as their markers do; the thigh's hip moves with the pelvis."""
    rest = rest_figure.clean[0]
    pelvis = [at(label) for label in ("WaistLFront", "WaistRFront", "WaistLBack", "WaistRBack")]
    turn = fit_rotations(rest[pelvis], positions[:, pelvis])
    rest_hip = rest_figure.joints[f"hip.{side}"][0]
    hip = positions[:, pelvis].mean(axis=1) + turn @ (rest_hip - rest[pelvis].mean(axis=0))
    thigh = [at(side + label) for label in ("Thigh", "KneeOut")]
    rest_thigh = np.vstack([rest_hip, rest[thigh]])
    thigh_turn = fit_rotations(rest_thigh, np.concatenate([hip[:, None], positions[:, thigh]], axis=1), prior=turn)
    shank = [at(side + label) for label in ("KneeOut", "Shin", "AnkleOut")]
    shank_turn = fit_rotations(rest[shank], positions[:, shank], prior=thigh_turn)
    cosine = (thigh_turn[:, :, 2] * shank_turn[:, :, 2]).sum(axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def feet_of(names=NAMES):
    return [number for foot in landmarks.feet(names).values() for number in foot]


def planted(markers, reference, character, rate, names):
    """retarget(), and on the floor the feet of a mesh whose soles are right below their markers."""
    path = retarget(markers, reference, character, names)
    feet = feet_of(names)
    ground = character[feet, 2].min()
    vertices = np.concatenate([character, character[feet] * [1.0, 1.0, 0.0] + [0.0, 0.0, ground]])
    surface = SimpleNamespace(vertices=vertices, triangles=np.arange(len(vertices))[None])
    body = SimpleNamespace(surface=surface, ground=ground, height=np.ptp(character[:, 2]))
    given = SimpleNamespace(path=path, reference=character, landmarks=names)
    return on_floor(given, markers, np.arange(len(character)), body, ground, rate)[0]


@pytest.mark.parametrize("lifted, level, sits", [(0, 0, 0), (0.06, 0, 0), (-0.04, 0.5, 0), (0.08, 0, 1), (0.3, 0, 0)])
def test_soles_stand_on_the_floor_or_as_far_above_it_as_captured_and_toes_bend(lifted, level, sits):
    vertices, triangles, _ = body_mesh.body()
    body, walk = Body(Surface(vertices, triangles)), walking_figure.take(220)
    drift = np.array([0.0, 0.0, lifted]) + np.arange(220)[:, None, None] * np.array([0.0003, 0.0, 0.0])
    given = SimpleNamespace(path=walk.clean + drift, reference=REFERENCE, landmarks=NAMES)
    anchors = match_to_surface(REFERENCE, body.surface).vertex
    moved, cuffs = on_floor(given, given.path, anchors, body, level, 100.0, sits)
    level += lifted if sits or lifted > 0.2 else 0.0  # on a footrest, on a stage
    for side in "LR":
        heel, toe = walk.contacts[f"heel.{side}"], walk.contacts[f"toe.{side}"]
        foot, toes = (cuff for cuff in cuffs if cuff.segment[-1] == side)
        sole = vertices[(vertices[:, 2] < 0.02) & (vertices[:, 0] * foot.centre[0] > 0.0)]
        is_toes = sole[:, 1] <= vertices[toes.vertices, 1].max()
        places = [cuff.centres[:, None] + (some - cuff.centre) @ cuff.turns.transpose(0, 2, 1)
                  for cuff, some in ((foot, sole[~is_toes]), (toes, sole[is_toes]))]  # fmt: skip
        heights = [points[..., 2] - level for points in places]
        assert np.abs(np.concatenate(heights, axis=1).min(axis=1))[heel | toe].max() < 0.005
        # A stiff foot would have its toes 5 cm below the floor when it leaves.
        assert np.abs(heights[1] - sole[is_toes, 2])[toe].max() < 0.01
        assert np.ptp(heights[0][toe & ~heel], axis=1).max() > 0.08, "the heel is up"
        assert largest_travel(places[1], np.repeat(toe[:, None], is_toes.sum(), axis=1)) < 0.005 * HEIGHT, "no slide"
        assert np.abs(moved[:, at(f"{side}ToeTip"), 2] - REFERENCE[at(f"{side}ToeTip"), 2] - level)[toe].max() < 0.02
        assert np.ptp((moved - walk.clean)[:, at(f"{side}Heel"), 2]) < 0.02, "nothing else is changed"


def test_a_step_of_a_walk_tells_how_the_person_stands():
    walk, step, foot = walking_figure.take(220), 30, [at(label) for label in walking_figure.FOOT_LABELS["R"]]
    assert not walk.contacts["heel.R"][step] and not walk.contacts["toe.R"][step]
    stands = standing(walk.clean, step, NAMES, 100.0)
    others = [name is None or not name.endswith(".R") for name in NAMES]
    assert np.array_equal(stands[others], walk.clean[step][others])
    assert np.abs(stands[foot, 2] - REFERENCE[foot, 2]).max() < 0.005, "flat on the floor"
    far, near = ((points[at("RAnkleOut")] - points[at("WaistRFront")])[1] for points in (walk.clean[step], stands))
    assert abs(near) < 0.21 < abs(far), "below the pelvis"
    assert np.array_equal(standing(REFERENCE[None].repeat(9, axis=0), 4, NAMES, 100.0), REFERENCE)


def largest_slide(result, capture, names=NAMES, height=HEIGHT, rate=100.0):
    feet = feet_of(names)
    stands = find_stances(capture[:, feet], rate, height, 0.09)
    assert stands.any()
    return largest_travel(result[:, feet], stands)


def largest_travel(positions, stands):
    """How far any of k markers, positions (f, k, 3), goes on the ground from where a stance of stands (f, k) begins."""
    stances_of = ((marker, run) for marker in range(stands.shape[1]) for run in runs(stands[:, marker]))
    paths = (positions[begin:end, marker, :2] for marker, (begin, end) in stances_of)
    return max(float(np.nanmax(np.linalg.norm(path - path[0], axis=1))) for path in paths)


def largest_second_difference(positions):
    return np.nanmax(np.abs(np.diff(positions, 2, axis=0)))


@pytest.mark.parametrize("noise", [0.0, 0.0005])
@pytest.mark.parametrize("legs", [0.7, 0.85, 1.3])
def test_other_legs_walk_alike(legs, noise):
    walk, rest = walking_figure.take(400, noise=noise), walking_figure.t_pose(legs)
    result = planted(walk.positions, REFERENCE, rest.clean[0], 100.0, NAMES)
    assert largest_slide(result, walk.clean) < 0.01 * rest.height
    for side in "LR":
        assert np.abs(knee_angles(result, rest, side) - walk.knee_angles[side]).max() < 5.0
    # No popping: path for path hardly rougher than the capture, however long the legs.
    rougher = max(1.0, legs) * 1.1
    assert largest_second_difference(result) < rougher * largest_second_difference(walk.positions)
    # The character's lengths, and feet on its ground.
    for pair in (("LKneeOut", "LAnkleOut"), ("RThigh", "RKneeOut"), ("LHeel", "LToeOut"), ("HeadTop", "HeadFront")):
        one, other = pair
        lengths = np.linalg.norm(result[:, at(one)] - result[:, at(other)], axis=1)
        wanted = np.linalg.norm(rest.clean[0, at(one)] - rest.clean[0, at(other)])
        assert np.abs(lengths / wanted - 1.0).max() < 0.025
    feet = feet_of()
    assert np.abs(result[:, feet, 2].min(axis=1) - walk.positions[:, feet, 2].min(axis=1)).max() < 0.03
    flat = walk.contacts["heel.L"] & walk.contacts["toe.L"]
    assert np.abs(result[flat][:, at("LHeel"), 2] - rest.clean[0, at("LHeel"), 2]).max() < 0.004


@pytest.mark.parametrize("legs", [0.6, 1.3])
def test_feet_stand_on_stairs(legs):
    walk, rest = walking_figure.take(400, drop=0.3, noise=0.0005), walking_figure.t_pose(legs)
    result = planted(walk.positions, REFERENCE, rest.clean[0], 100.0, NAMES)
    for side in "LR":
        flat = walk.contacts[f"heel.{side}"] & walk.contacts[f"toe.{side}"]
        foot = [at(label) for label in walking_figure.FOOT_LABELS[side]]
        stands = np.repeat(flat[:, None], len(foot), axis=1)
        assert largest_travel(result[:, foot], stands) < 0.01 * rest.height
        levels = [result[begin:end, at(f"{side}Heel"), 2].mean() for begin, end in runs(flat)[1:-1]]
        assert np.ptp(np.diff(levels)) < 0.01 and abs(np.diff(levels).mean() / legs + 0.3) < 0.03
    lengths = np.linalg.norm(result[:, at("LKneeOut")] - result[:, at("LAnkleOut")], axis=1)
    wanted = np.linalg.norm(rest.clean[0, at("LKneeOut")] - rest.clean[0, at("LAnkleOut")])
    assert np.abs(lengths / wanted - 1.0).max() < 0.04


@pytest.mark.parametrize("scale", [1.0, 2.5])
@pytest.mark.parametrize("names", [NAMES, (None,) * 41], ids=["named", "unnamed"])
def test_a_character_like_the_actor_gets_the_capture_back(scale, names):
    walk = walking_figure.take(250, noise=0.0005)
    result = retarget(walk.positions, REFERENCE, scale * REFERENCE, names)
    assert np.abs(result - scale * walk.positions).max() < 1e-6


def test_the_way_that_the_capture_looks_and_where_it_is_do_not_matter():
    walk, character = walking_figure.take(200), walking_figure.t_pose(0.7).clean[0]
    turn, shift = walking_figure.turn_z(np.array(2.1)), np.array([3.0, -7.0, 0.0])
    expected = retarget(walk.clean, REFERENCE, character, NAMES) @ turn.T + shift
    moved = retarget(walk.clean @ turn.T + shift, REFERENCE @ turn.T + shift, character @ turn.T + shift, NAMES)
    assert np.abs(moved - expected).max() < 1e-6


def test_a_wide_torso_and_long_arms_are_the_characters():
    walk = walking_figure.take(150)
    character = REFERENCE.copy()
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for label in ("ElbowOut", "UArmHigh", "WristOut", "WristIn", "HandOut"):
            beyond = sign * character[at(side + label), 0] - 0.18
            character[at(side + label), 0] = sign * (0.18 + 1.4 * beyond)
    result = retarget(walk.clean, REFERENCE, character, NAMES)
    upper_arms = [p[:, at("LElbowOut")] - p[:, at("LUArmHigh")] for p in (result, walk.clean)]
    lengths, captured = np.linalg.norm(upper_arms, axis=2)
    wanted = np.linalg.norm(character[at("LElbowOut")] - character[at("LUArmHigh")])
    assert np.abs(lengths / wanted - 1.0).max() < 0.05
    assert (lengths > 1.3 * captured).all()
    assert np.abs(result[:, at("LKneeOut")] - walk.clean[:, at("LKneeOut")]).max() < 1e-3


def test_missing_samples_stay_missing_and_hardly_move_the_others():
    walk, character = walking_figure.take(200), walking_figure.t_pose(0.7).clean[0]
    whole = planted(walk.clean, REFERENCE, character, 100.0, NAMES)
    holed = walk.clean.copy()
    holed[50:120, [at("LShin"), at("RAnkleOut")]] = np.nan
    holed[80, :] = np.nan
    holed[90:100, at("WaistLFront")] = np.nan
    result = planted(holed, REFERENCE, character, 100.0, NAMES)
    assert np.array_equal(np.isnan(result), np.isnan(holed))
    assert np.nanmax(np.linalg.norm(result - whole, axis=2)) < 0.03


def test_wrong_input_is_refused_with_numbers():
    walk = walking_figure.take(10)
    with pytest.raises(InvalidMotionError, match="at least 3"):
        retarget(walk.clean[:, :2], REFERENCE[:2], REFERENCE[:2], NAMES[:2])
    with pytest.raises(InvalidMotionError, match="turned by 180 degrees"):
        retarget(walk.clean, REFERENCE, REFERENCE * [-1.0, -1.0, 1.0], NAMES)
