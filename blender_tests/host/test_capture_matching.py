# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: markers laid onto a mesh, matched to it, and the skin under them; without Blender."""

import numpy as np
import pytest

from addon.capture.core import marker_sets, readers
from addon.capture.core.alignment import align_to_mesh, similarity
from addon.capture.core.body import Body
from addon.capture.core.limb_posing import posed_and_actor
from addon.capture.core.matching import match_to_surface, skin_targets
from addon.errors import InvalidMotionError
from addon.scene.core.motion import nearest_rotations
from addon.scene.surface import Surface
from blender_tests.support import body_mesh, mesh_files, walking_figure

LABELS = walking_figure.LABELS
NAMES = marker_sets.recognise(LABELS).landmarks
REFERENCE = walking_figure.t_pose().clean[0]
VERTICES, TRIANGLES, BONES = body_mesh.body()
SURFACE = Surface(VERTICES, TRIANGLES)
BODY = Body(SURFACE)


def moved(points, matrix):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def placed(scale, angle, shift):
    matrix = np.eye(4)
    matrix[:3, :3] = scale * walking_figure.turn_z(np.array(angle))
    matrix[:3, 3] = shift
    return matrix


def test_a_similarity_is_found_from_picked_pairs():
    turn = walking_figure.turn_x(np.array(0.4)) @ walking_figure.turn_z(np.array(2.0))
    source = np.random.default_rng(0).standard_normal((5, 3))
    target = 3.7 * source @ turn.T + [1.0, 2.0, 3.0]
    assert np.abs(moved(source, similarity(source, target)) - target).max() < 1e-12
    assert np.abs(moved(source[:3], similarity(source[:3], target[:3])) - target[:3]).max() < 1e-12
    assert np.abs(similarity(source, target)[:3, :3] - 3.7 * turn).max() < 1e-12
    # Mirrored points get the nearest rotation, no mirror.
    assert np.linalg.det(similarity(target, target * [-1.0, 1.0, 1.0])[:3, :3]) > 0.0


@pytest.mark.parametrize("seed", range(4))
def test_a_t_pose_is_aligned_whatever_unit_place_and_turn_the_mesh_has(seed):
    rng = np.random.default_rng(seed)
    truth = placed(rng.choice([0.01, 1.0, 39.4]), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(-9.0, 9.0, 3))
    markers = REFERENCE + 0.002 * rng.standard_normal((41, 3))
    found = align_to_mesh(markers, NAMES, Body(Surface(moved(VERTICES, truth), TRIANGLES)))
    scale = np.cbrt(np.linalg.det(truth[:3, :3]))
    off = np.linalg.norm(moved(REFERENCE, found.matrix) - moved(REFERENCE, truth), axis=1) / scale
    assert np.sqrt((off**2).mean()) < 0.025, "metres on an adult"
    assert found.scale == pytest.approx(scale, rel=0.03)
    assert found.quality < 0.01 and found.certainty > 1.2
    assert found.matrix[2, :2] == pytest.approx([0.0, 0.0]) and found.matrix[3].tolist() == [0, 0, 0, 1]


def test_where_surface_and_sides_of_names_tell_other_ways_to_look_it_is_a_guess():
    exchanged = [name and name.translate(str.maketrans("LR", "RL")) for name in NAMES]
    found = align_to_mesh(REFERENCE, exchanged, BODY)
    assert found.certainty < 1.1 and found.matrix[:3, :3] == pytest.approx(np.eye(3), abs=0.05), "by the surface"


@pytest.mark.slow
def test_missing_markers_and_inward_normals_do_not_matter():
    some = np.arange(41) % 5 != 0
    names = [name for name, is_there in zip(NAMES, some, strict=True) if is_there]
    for triangles in (TRIANGLES, TRIANGLES[:, ::-1]):
        found = align_to_mesh(REFERENCE[some], names, Body(Surface(VERTICES, triangles)))
        off = np.linalg.norm(moved(REFERENCE, found.matrix) - REFERENCE, axis=1)
        assert np.sqrt((off**2).mean()) < 0.03


@pytest.mark.slow
def test_names_that_nobody_knows_are_no_hindrance():
    found = align_to_mesh(REFERENCE, (None,) * 41, BODY)
    assert found.quality < 0.012
    assert found.scale == pytest.approx(1.0, rel=0.06)


def test_what_cannot_be_aligned_is_told():
    with pytest.raises(InvalidMotionError, match="Only 3 markers"):
        align_to_mesh(REFERENCE[:3], NAMES[:3], BODY)
    with pytest.raises(InvalidMotionError, match="flat"):
        align_to_mesh(REFERENCE, NAMES, Body(Surface(VERTICES * [1.0, 1.0, 0.0], TRIANGLES)))
    with pytest.raises(InvalidMotionError, match="one height"):
        align_to_mesh(REFERENCE * [1.0, 1.0, 0.0], NAMES, BODY)
    with pytest.raises(InvalidMotionError, match="no surface"):
        Surface(VERTICES, TRIANGLES[:0])


@pytest.mark.slow
@pytest.mark.parametrize("mesh", ["models/human_man.obj", "models/human_woman.obj", "makehuman/base.obj"])
@pytest.mark.parametrize("take", ["pig-walk/PiG_Calibration-FlatFoot-One.c3d", "rajagopal/static_walk_1.trc"])
def test_real_static_poses_look_the_way_real_bodies_do(mesh, take):
    vertices, triangles = mesh_files.real_body(mesh)
    still = readers.read(mesh_files.path_of(f"mocap/{take}"))
    frame = still.frames // 2
    names = marker_sets.recognise(still.labels).landmarks
    found = align_to_mesh(still.positions[frame], names, Body(Surface(vertices, triangles)))
    left, right = (still.positions[frame, names.index(f"pelvis.front.{side}")] for side in "LR")
    across = found.matrix[:3, :3] @ (left - right) / np.linalg.norm(found.matrix[:3, :3] @ (left - right))
    assert across[0] > np.cos(np.radians(12.0)), "its left is at +X"
    assert found.quality < 0.015
    body_height = np.ptp(vertices[np.unique(triangles)][:, 2]) / found.scale
    assert 1.5 < body_height < 2.0


@pytest.mark.slow
@pytest.mark.parametrize("take", ["makehuman/tpose.bvh", "mocap/bvh/scaled_131_01.bvh"])
def test_real_skeletons_lie_in_the_middle_of_a_real_body(take):
    vertices, triangles = mesh_files.real_body("makehuman/base.obj")
    read = readers.read(mesh_files.path_of(take))
    names = marker_sets.recognise(read.labels).landmarks
    known = [k for k, name in enumerate(names) if name]
    names = [names[k] for k in known]
    body = Body(Surface(vertices, triangles), is_for_joints=True)
    found = align_to_mesh(read.positions[0, known], names, body)
    posed = posed_and_actor(moved(read.positions[0, known], found.matrix), names, body)[0]
    height = np.ptp(vertices[np.unique(triangles), 2])
    places = dict(zip(names, posed / height, strict=True))
    across = places["hip.L"] - places["hip.R"]
    assert across[0] > np.cos(np.radians(15.0)) * np.linalg.norm(across), "its left is at +X"
    assert np.abs(places["hip.L"] + places["hip.R"])[0] < 0.04
    for name, (x, z) in {"knee.joint": (0.09, -0.21), "ankle.joint": (0.13, -0.45), "elbow.joint": (0.2, 0.21)}.items():
        for side, sign in (("L", 1.0), ("R", -1.0)):
            off = places[f"{name}.{side}"][[0, 2]] - [sign * x, z]
            assert np.linalg.norm(off) < 0.05, (name, side, places[f"{name}.{side}"])
    assert found.certainty > 1.1


def hanging(points, down=1.1, bent=0.9):
    """The T-pose's markers with arms turned down and elbows bent forward."""
    result, joints = points.copy(), walking_figure.t_pose().joints
    for side, sign in (("L", 1.0), ("R", -1.0)):
        shoulder, elbow = joints[f"shoulder.{side}"][0], joints[f"elbow.{side}"][0]
        turn, bend = walking_figure.turn_y(np.array(sign * down)), walking_figure.turn_z(np.array(-sign * bent))
        for part in ("WristOut", "WristIn", "HandOut", "UArmHigh", "ElbowOut"):
            place = result[LABELS.index(side + part)]
            if part[0] in "WH":
                place = elbow + bend @ (place - elbow)
            result[LABELS.index(side + part)] = shoulder + turn @ (place - shoulder)
    return result


@pytest.mark.parametrize("down, aside", [(0.4, 0.0), (1.1, 0.0), (1.1, 0.12), (1.1, -0.12)])
def test_hanging_arms_are_brought_to_those_of_the_mesh_though_it_is_to_one_side(down, aside):
    captured = hanging(REFERENCE, down) + np.array([aside, 0.0, 0.0])
    arms = [k for k, name in enumerate(NAMES) if name.split(".")[0] in ("upper_arm", "elbow", "wrist", "hand")]
    assert np.linalg.norm(captured - REFERENCE, axis=1).max() > 0.2
    posed = posed_and_actor(captured, NAMES, BODY)[0]
    others = np.delete(np.arange(41), arms)
    assert np.abs(posed[others] - captured[others]).max() < 0.06 + abs(aside)
    assert np.linalg.norm(posed - REFERENCE, axis=1)[arms].max() < 0.07 + abs(aside), "but for twists about the arm"
    assert match_to_surface(posed, SURFACE).distance[arms].max() < 0.06 + 0.1 * abs(aside)
    # The lengths are still those of the capture.
    one, other = LABELS.index("LUArmHigh"), LABELS.index("LElbowOut")
    length = [np.linalg.norm(p[one] - p[other]) for p in (posed, captured)]
    assert length[0] == pytest.approx(length[1], rel=1e-9)


@pytest.mark.parametrize("angle, raised", [(1.57, ("thigh",)), (2.1, ("thigh", "shank", "foot", "toe"))])
def test_who_sits_or_holds_legs_up_has_the_size_of_the_mesh_and_legs_that_are_brought_to_its(angle, raised):
    captured, joints, lift = REFERENCE.copy(), walking_figure.t_pose().joints, walking_figure.turn_x(np.array(-angle))
    for label, (bone, _) in walking_figure.SIDE_MARKERS.items():
        for side in "RL"[len(raised) // 3 :] if bone in ("thigh", "shank", "foot", "toe") else "":
            hip, knee, place = joints[f"hip.{side}"][0], joints[f"knee.{side}"][0], captured[LABELS.index(side + label)]
            place[:] += lift @ (place - hip) - (place - hip) if bone in raised else lift @ (knee - hip) - (knee - hip)
    found = align_to_mesh(captured, NAMES, BODY)
    assert found.scale == pytest.approx(1.0, abs=0.05)
    posed = posed_and_actor(moved(captured, found.matrix), NAMES, BODY)[0]
    assert np.linalg.norm(posed - REFERENCE, axis=1).max() < 0.16, "0.35 with bent knees, 0.17 with feet as they were"


@pytest.mark.slow
def test_limbs_that_are_right_or_unknown_are_left_alone():
    posed = posed_and_actor(REFERENCE, NAMES, BODY)[0]
    assert np.linalg.norm(posed - REFERENCE, axis=1).max() < 0.03
    captured = hanging(REFERENCE)
    assert np.array_equal(posed_and_actor(captured, (None,) * 41, BODY)[0], captured)
    some = [number for number, label in enumerate(LABELS) if label not in ("LElbowOut", "RHandOut")]
    posed = posed_and_actor(captured[some], [NAMES[number] for number in some], BODY)[0]
    wrist = LABELS.index("LWristIn")
    assert np.array_equal(posed[some.index(wrist)], captured[wrist])


#: Joints of the figure, as a skeleton has them.
JOINTS = {
    "Hips": "pelvis", "Spine": "chest", "Neck": "neck", "Head": "head",
    **{f"{word}{name}": f"{joint}.{side}" for side, word in (("L", "Left"), ("R", "Right")) for name, joint in (
        ("UpLeg", "hip"), ("Leg", "knee"), ("Foot", "ankle"), ("Arm", "shoulder"), ("ForeArm", "elbow"),
        ("Hand", "wrist"),
    )},
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("down", [0.0, 1.1])
def test_a_skeleton_gets_into_the_body_and_its_arms_into_those_of_the_mesh(down):
    figure = walking_figure.t_pose().joints
    rest = np.array([figure[joint][0] for joint in JOINTS.values()])
    captured, labels = rest.copy(), list(JOINTS)
    for side, sign in (("Left", 1.0), ("Right", -1.0)):
        turn, shoulder = walking_figure.turn_y(np.array(sign * down)), rest[labels.index(f"{side}Arm")]
        for name in ("ForeArm", "Hand"):
            captured[labels.index(side + name)] = shoulder + turn @ (rest[labels.index(side + name)] - shoulder)
    truth = placed(1.0, 2.1, [3.0, 1.0, 0.5])
    names = marker_sets.recognise(labels).landmarks
    body = Body(Surface(moved(VERTICES, truth), TRIANGLES), is_for_joints=True)
    found = align_to_mesh(captured, names, body)
    posed = posed_and_actor(moved(captured, found.matrix), names, body)[0]
    off = np.linalg.norm(posed - moved(rest, truth), axis=1)
    assert off.max() < 0.12, dict(zip(labels, off.round(3), strict=True))
    assert found.certainty > 1.1


def test_no_place_on_the_surface_is_nearer_than_the_nearest():
    rng = np.random.default_rng(1)
    points = rng.uniform(-1.0, 2.0, (20, 3))
    tries = rng.dirichlet((0.4, 0.4, 0.4), 50)  # many near the sides and corners
    everywhere = np.einsum("sc,tcj->stj", tries, VERTICES[TRIANGLES]).reshape(-1, 3)
    triangle, shares, point, distance = SURFACE.nearest(points)
    assert np.abs(np.linalg.norm(points - point, axis=1) - distance).max() < 1e-12
    assert np.abs(np.einsum("kc,kcj->kj", shares, VERTICES[TRIANGLES[triangle]]) - point).max() < 1e-12
    assert shares.min() >= 0.0 and np.abs(shares.sum(axis=1) - 1.0).max() < 1e-12
    for at, least in zip(points, distance, strict=True):
        away = np.linalg.norm(everywhere - at, axis=1).min()
        assert least - 1e-12 < away < least + 0.05


def test_triangles_and_normals_that_do_not_fit_are_refused():
    meanvalue = pytest.importorskip("meanvalue")
    with pytest.raises(meanvalue.InvalidInput, match="none of the 3 vertices"):
        meanvalue.Surface(np.eye(3), [[0, 1, 3]])
    with pytest.raises(meanvalue.InvalidInput, match="2 points and 1 normals"):
        meanvalue.Surface(np.eye(3), [[0, 1, 2]]).nearest(np.zeros((2, 3)), np.zeros((1, 3)))
    face, weights, distance = meanvalue.Surface(np.eye(3), [[0, 1, 2]]).nearest([[0, 0, 0]], -np.eye(3)[:1])
    assert face.tolist() == [-1] and not weights.any() and np.isinf(distance).all()


def test_matches_lie_on_the_surface_and_offsets_lead_back():
    match = match_to_surface(REFERENCE, SURFACE)
    assert len(set(match.vertex)) == 41
    assert np.abs(VERTICES[match.vertex] + match.offset - REFERENCE).max() < 1e-12
    assert (match.distance <= np.linalg.norm(match.offset, axis=1) + 1e-12).all()
    given = match_to_surface(REFERENCE, SURFACE, {4: 7, 5: int(match.vertex[6])})
    assert given.vertex[[4, 5]].tolist() == [7, match.vertex[6]] and len(set(given.vertex)) == 41
    assert given.distance[4] == np.linalg.norm(REFERENCE[4] - VERTICES[7])


def test_small_meshes_are_told():
    with pytest.raises(InvalidMotionError, match="3 vertices for 41 markers"):
        match_to_surface(REFERENCE, Surface(VERTICES, TRIANGLES[:1]))


def test_targets_turn_with_the_body():
    match = match_to_surface(REFERENCE, SURFACE)
    turn = walking_figure.turn_x(np.array(1.2)) @ walking_figure.turn_z(np.array(2.5))
    targets = skin_targets((REFERENCE @ turn.T)[None] + 2.0, REFERENCE, match.offset, (None,) * 41)
    assert np.abs(targets[0] - (VERTICES[match.vertex] @ turn.T + 2.0)).max() < 1e-8


@pytest.mark.parametrize("names", [NAMES, (None,) * 41], ids=["named", "unnamed"])
def test_on_a_walk_targets_follow_the_skin_far_better_than_offsets_that_are_not_turned(names):
    walk = walking_figure.take(220)
    match = match_to_surface(REFERENCE, SURFACE)
    truth = body_mesh.posed(VERTICES[match.vertex], BONES[match.vertex], np.arange(220) / 100.0)
    # Shoulders' markers are the trunk's, but the skin that is nearest to them is an arm's; this body's toes are stiff.
    same = [k for k, label in enumerate(LABELS) if "Shoulder" not in label and "ToeTip" not in label]
    error = np.linalg.norm(skin_targets(walk.clean, REFERENCE, match.offset, names) - truth, axis=2)[:, same]
    unturned = np.linalg.norm(walk.clean - (REFERENCE - VERTICES[match.vertex]) - truth, axis=2)[:, same]
    assert np.sqrt((error**2).mean()) < 0.45 * np.sqrt((unturned**2).mean())
    assert error.max() < 0.02


@pytest.mark.parametrize("offset", 0.02 * np.eye(3), ids=["aside", "behind", "above"])
def test_skin_at_a_joint_of_the_leg_turns_half_way_between_both_bones(offset):
    joints, turns, _ = walking_figure.walking(np.arange(120) / 100.0)
    walk = walking_figure.markers_on(joints, turns)
    targets = skin_targets(walk, REFERENCE, np.tile(offset, (len(LABELS), 1)), NAMES)
    for joint, upper, lower in (("Knee", "thigh", "shank"), ("Ankle", "shank", "foot")):
        for side in "LR":
            number = LABELS.index(f"{side}{joint}Out")
            half = nearest_rotations(turns[f"{upper}.{side}"] + turns[f"{lower}.{side}"])
            off = walk[:, number] - targets[:, number] - half @ offset
            assert np.linalg.norm(off, axis=1).max() < 0.004, (joint, side)


def test_missing_neighbours_hardly_matter_and_missing_markers_stay_missing():
    walk = walking_figure.take(120)
    match = match_to_surface(REFERENCE, SURFACE)
    whole = skin_targets(walk.clean, REFERENCE, match.offset, NAMES)
    holed = walking_figure.drop_samples(walk.clean, 0.1, np.random.default_rng(0))
    targets = skin_targets(holed, REFERENCE, match.offset, NAMES)
    assert np.array_equal(np.isnan(targets), np.isnan(holed))
    assert np.sqrt(np.nanmean((targets - whole) ** 2)) < 0.003
