# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: how arms and feet of a reference are laid on those of a mesh, for several marker sets."""

import numpy as np
import pytest

from addon.capture.core import marker_sets, readers
from addon.capture.core.alignment import align_to_mesh
from addon.capture.core.body import Body
from addon.capture.core.limb_posing import Limb, posed_and_actor
from addon.capture.core.matching import match_to_surface, skin_targets
from addon.scene.core import motion
from addon.scene.surface import Surface
from blender_tests.support import body_mesh, mesh_files, walking_figure

VERTICES, TRIANGLES, BONES = body_mesh.body()
BODY = Body(Surface(VERTICES, TRIANGLES))

ON_ARMS = ("upper_arm", "forearm")
OTHERS = {name: place for name, place in walking_figure.SIDE_MARKERS.items() if place[0] not in ON_ARMS}
ELBOW = {"elbow": ("upper_arm", (0.27, 0.03, 0.034))}
#: landmark: (bone, place), what sets have on the figure's arms; palms are down.
ARMS = {
    "Plug-in Gait": {
        "upper_arm": ("upper_arm", (0.15, 0.03, 0.035)), **ELBOW, "forearm": ("forearm", (0.13, 0.0, 0.036)),
        "wrist.thumb": ("forearm", (0.22, -0.036, 0.0)), "wrist.little": ("forearm", (0.22, 0.036, 0.0)),
        "hand": ("forearm", (0.32, -0.01, 0.026)),
    },
    "Rajagopal 2015": {
        "upper_arm": ("upper_arm", (0.15, 0.0, 0.045)), **ELBOW, "elbow.inner": ("upper_arm", (0.27, -0.03, -0.034)),
        "forearm": ("forearm", (0.13, 0.0, 0.036)), "wrist": ("forearm", (0.22, 0.0, 0.036)),
    },
    "Baseline 41": {
        "upper_arm": walking_figure.SIDE_MARKERS["UArmHigh"], "elbow": walking_figure.SIDE_MARKERS["ElbowOut"],
        "wrist.little": walking_figure.SIDE_MARKERS["WristOut"], "wrist.thumb": walking_figure.SIDE_MARKERS["WristIn"],
        "hand": walking_figure.SIDE_MARKERS["HandOut"],
    },
}  # fmt: skip


def markers_of(set_name, joints, turns):
    """((f, m, 3), m landmarks): the figure with the arms of a set, and the others of its own."""
    arms = ARMS[set_name]
    positions = walking_figure.markers_on(joints, turns, sides={**OTHERS, **arms})
    labels = [*walking_figure.CENTRE_MARKERS, *(side + name for side in "LR" for name in OTHERS)]
    known = dict(zip(labels, marker_sets.recognise(labels).landmarks, strict=True))
    sides = [known.get(side + name) or f"{name}.{side}" for side in "LR" for name in (*OTHERS, *arms)]
    return positions, tuple([known[label] for label in walking_figure.CENTRE_MARKERS] + sides)


def standing(down, bent, roll):
    """(joints, turns) of the T-pose with arms turned down, elbows bent forward and palms turned forward by `roll`."""
    joints, turns = walking_figure.upright(1, 1.0)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        turns[f"upper_arm.{side}"] = walking_figure.turn_y(np.array([sign * down]))
        beyond = walking_figure.turn_z(np.array([-sign * bent])) @ walking_figure.turn_x(np.array([roll]))
        turns[f"forearm.{side}"] = turns[f"upper_arm.{side}"] @ beyond
    return {**joints, **walking_figure.trunk_and_arms(joints["pelvis"], turns)}, turns


def with_legs(joints, turns):
    """(m, 3): markers of the figure whose legs are turned like that."""
    for side in "LR":
        joints[f"knee.{side}"] = joints[f"hip.{side}"] + turns[f"thigh.{side}"] @ [0.0, 0.0, -walking_figure.THIGH]
        joints[f"ankle.{side}"] = joints[f"knee.{side}"] + turns[f"shank.{side}"] @ [0.0, 0.0, -walking_figure.SHANK]
        joints[f"toe.{side}"] = joints[f"ankle.{side}"] + turns[f"foot.{side}"] @ walking_figure.TOE
    return walking_figure.markers_on(joints, turns)[0]


@pytest.mark.slow
@pytest.mark.parametrize("roll", [0.0, 0.9, -0.9])
@pytest.mark.parametrize("set_name", ARMS)
def test_palms_look_as_in_the_capture_however_the_reference_holds_its_arms(set_name, roll):
    captured, names = markers_of(set_name, *standing(0.7, 0.8, roll))
    posed = posed_and_actor(captured[0], names, BODY)[0]
    match = match_to_surface(posed, BODY.surface)
    joints, turns, _ = walking_figure.walking(np.arange(0, 110, 6) / 100.0)
    for side in "LR":  # palms turn while it walks
        turns[f"forearm.{side}"] = turns[f"forearm.{side}"] @ walking_figure.turn_x(np.linspace(-0.7, 0.7, 19))
    walk, _ = markers_of(set_name, joints, turns)
    targets = skin_targets(walk, posed, match.offset, names)
    rest, _ = walking_figure.upright(1, 1.0)
    for side in "LR":
        here = [k for k, name in enumerate(names) if name[:5] in ("forea", "wrist", "hand.") and name.endswith(side)]
        vertices = match.vertex[here]
        assert set(BONES[vertices]) <= {f"forearm.{side}", f"hand.{side}"}
        local = VERTICES[vertices] - rest[f"elbow.{side}"][0]
        truth = joints[f"elbow.{side}"][:, None] + np.einsum("fij,kj->fki", turns[f"forearm.{side}"], local)
        off = np.linalg.norm(targets[:, here] - truth, axis=2)
        assert np.sqrt((off**2).mean()) < 0.035, "metres; a palm that looks the wrong way is 0.07 off"
        # Which way the skin at the wrist is from the forearm's axis: so palms look.
        wrist = [number for number, k in enumerate(here) if names[k].startswith("wrist")]
        found, right = (ways_from_axis(some[:, wrist], joints, side) for some in (targets[:, here], truth))
        angle = np.degrees(np.arccos(np.clip((found * right).sum(axis=2), -1.0, 1.0)))
        assert angle.mean() < 25.0 and angle.max() < 30.0, (side, angle.max())


def ways_from_axis(points, joints, side):
    """(f, k, 3) unit vectors to points (f, k, 3) from the line through elbow and wrist."""
    axis = joints[f"wrist.{side}"] - joints[f"elbow.{side}"]
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    ways = points - joints[f"wrist.{side}"][:, None]
    ways -= (ways * axis[:, None]).sum(axis=2, keepdims=True) * axis[:, None]
    return ways / np.linalg.norm(ways, axis=2, keepdims=True)


def test_feet_stay_flat_where_legs_are_moved_apart():
    joints, turns = walking_figure.upright(1, 1.0)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for bone in ("thigh", "shank"):
            turns[f"{bone}.{side}"] = walking_figure.turn_y(np.array([-sign * np.radians(9.0)]))
        turns[f"foot.{side}"] = turns[f"toe.{side}"] = walking_figure.turn_z(np.array([sign * 0.3]))
    captured = with_legs(joints, turns)
    names = marker_sets.recognise(walking_figure.LABELS).landmarks
    posed = posed_and_actor(captured, names, BODY)[0]
    reference = walking_figure.t_pose().clean[0]
    for side in "LR":
        foot = [walking_figure.LABELS.index(label) for label in walking_figure.FOOT_LABELS[side]]
        assert np.linalg.norm(captured - reference, axis=1)[foot].min() > 0.08
        assert np.linalg.norm(posed - reference, axis=1)[foot].max() < 0.03
        assert np.ptp(posed[foot, 2] - captured[foot, 2]) < 1e-9, "not tilted"
    points = np.array([(0.0, 0.0, 0.0), (0.0, -0.12, -0.07), (0.02, -0.19, -0.08)])
    leg = Limb(points, points[0], [], [1, 2], [0], points * (-1.0, 1.0, 1.0), points, None, 1.8)
    assert np.abs(leg.foot(points, [1, 2], [0])[:, 2] - points[1:, 2]).max() < 1e-9, "not turned over either"


def test_thighs_of_a_run_are_not_rolled():
    """Of a long step, the left leg behind and bent."""
    joints, turns = walking_figure.upright(1, 1.0)
    for side, ahead in (("L", (-0.43, -0.81, -0.41)), ("R", (0.93, 0.45, 0.23))):
        for bone, angle in zip(("thigh", "shank", "foot", "toe"), (*ahead, ahead[-1]), strict=True):
            turns[f"{bone}.{side}"] = walking_figure.turn_x(np.array([-angle]))
    captured, names = with_legs(joints, turns), marker_sets.recognise(walking_figure.LABELS).landmarks
    aligned = motion.apply(align_to_mesh(captured, names, BODY).matrix, captured)
    posed = posed_and_actor(aligned, names, BODY)[0]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        thigh = posed[walking_figure.LABELS.index(side + "Thigh")] - joints[f"hip.{side}"][0]
        assert abs(np.degrees(np.arctan2(-thigh[1], sign * thigh[0])) - 19.4) < 25.0, "degrees ahead of outward"


@pytest.mark.slow
def test_noise_does_not_choose_how_an_arm_is_rolled():
    """Markers that lie as badly on a round arm whichever way it is rolled: they stay as they are rolled."""
    along, around = np.meshgrid(np.linspace(0.0, 0.6, 60), np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False))
    normals = np.stack([0.0 * around, np.cos(around), np.sin(around)], axis=-1).reshape(-1, 3)
    skin = np.outer(along.ravel(), [1.0, 0.0, 0.0]) + 0.04 * normals
    markers = np.array([(0.12, 0.14, 0.0), (0.3, 0.04, 0.0), (0.3, -0.04, 0.0), (0.4, 0.05, 0.1), (0.5, 0.03, 0.14)])
    posed = []
    for seed in range(8):
        noisy = skin + np.random.default_rng(seed).normal(scale=2e-4, size=skin.shape)
        arm = Limb(markers, np.zeros(3), [0, 1, 2], [3, 4], [1, 2], noisy, normals, np.zeros((5, 3)), 1.8)
        posed.append(arm.posed(np.array([0.6, 0.0, 0.0]), is_stretched=True))
    assert np.linalg.norm(np.array(posed) - posed[0], axis=2).max() < 0.015, "metres; rolled otherwise 0.19"


@pytest.mark.slow
@pytest.mark.parametrize("mesh", ["models/human_man.obj", "models/human_woman.obj", "makehuman/base.obj"])
def test_markers_of_a_real_take_are_on_the_backs_of_real_wrists(mesh):
    vertices, triangles = mesh_files.real_body(mesh)
    still = readers.read(mesh_files.path_of("mocap/rajagopal/static_walk_1.trc"))
    names = marker_sets.recognise(still.labels).landmarks
    markers = still.positions[still.frames // 2]
    surface = Surface(vertices, triangles)
    found = align_to_mesh(markers, names, Body(surface)).matrix
    posed = posed_and_actor(markers @ found[:3, :3].T + found[:3, 3], names, Body(surface))[0]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        triangle, shares, _, _ = surface.nearest(posed[[names.index(f"wrist.{side}")]])
        normal = shares[0] @ surface.normals()[surface.triangles[triangle[0]]]
        # Of all these bodies palms are down, or down and inward where arms are lowered.
        assert normal @ [0.3 * sign, 0.0, 1.0] > 0.6, (side, normal)
        # The outer side of the elbow is not where the arm is folded: in front, where thumbs are.
        elbow = surface.nearest(posed[[names.index(f"elbow.{side}")]])
        normal = elbow[1][0] @ surface.normals()[surface.triangles[elbow[0][0]]]
        assert normal[1] > 0.1, (side, normal)


@pytest.mark.slow
@pytest.mark.parametrize("legs", [0.7, 1.0, 1.3])
def test_trunks_of_long_and_short_legged_bodies_get_the_markers_of_the_trunk(legs):
    names = marker_sets.recognise(walking_figure.LABELS).landmarks
    vertices, triangles, _ = body_mesh.body(legs)
    captured, right = walking_figure.t_pose().clean[0], walking_figure.t_pose(legs).clean[0]
    found = align_to_mesh(captured, names, Body(Surface(vertices, triangles))).matrix
    aligned = captured @ found[:3, :3].T + found[:3, 3]
    of_trunk = ("neck", "back", "sternum", "shoulder", "pelvis")
    trunk = [k for k, name in enumerate(names) if name.split(".")[0] in of_trunk]
    posed = posed_and_actor(aligned, names, Body(Surface(vertices, triangles)))[0]
    off = [np.sqrt(((points - right)[trunk] ** 2).sum(axis=1).mean()) for points in (aligned, posed)]
    assert off[1] < 0.035, "metres"
    assert legs == 1.0 or off[1] < 0.5 * off[0]


@pytest.mark.parametrize("legs", [0.7, 1.0, 1.3])
def test_the_actor_keeps_the_lengths_that_were_captured(legs):
    names = marker_sets.recognise(walking_figure.LABELS).landmarks
    vertices, triangles, _ = body_mesh.body(legs)
    captured = walking_figure.t_pose().clean[0] * np.ptp(vertices[:, 2]) / walking_figure.HEIGHT
    posed, actor = posed_and_actor(captured, names, Body(Surface(vertices, triangles)))
    for side in "LR":
        for ends in (("KneeOut", "AnkleOut"), ("Thigh", "KneeOut"), ("ElbowOut", "WristOut")):
            first, second = (walking_figure.LABELS.index(side + name) for name in ends)
            lengths = [np.linalg.norm(points[first] - points[second]) for points in (captured, posed, actor)]
            assert abs(lengths[2] / lengths[0] - 1.0) < 0.01, (side, ends, lengths)
            is_stretched = legs != 1.0 and ends[1] != "WristOut"
            assert (abs(lengths[1] / lengths[0] - 1.0) > 0.1) == is_stretched, (side, ends, lengths)
