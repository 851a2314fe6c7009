# SPDX-License-Identifier: GPL-3.0-or-later
"""Which markers of a take get handles: those of the person alone, however much of him is known."""

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import figure_body, meshes, sitting_figure, steps, take_files, walking_figure
from support.marked_tube import match

NAMES = walking_figure.LABELS
POSE = walking_figure.t_pose()
REST, GO = POSE.clean[0], np.outer(np.arange(30), (0.0, -0.03, 0.0))[:, None]
CRATE = np.array([(0.3 * x, 0.2 * y, 0.25 * z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
JOINTS = {"Neck": "neck", **{f"{side}{name}": f"{name.lower()}.{side}" for side in "LR" for name in (
    "Shoulder", "Elbow", "Wrist", "Hip", "Knee", "Ankle")}}  # fmt: skip
POINTS = {"Nose": "HeadFront", "Head": "HeadTop", "LBigToe": "LToeTip", "RBigToe": "RToeTip", "LHeel": "LHeel"}
VIDEO = [*(POSE.joints[name][0] for name in JOINTS.values()), *(REST[NAMES.index(name)] for name in POINTS.values())]


def matched(tmp_path, names, places, is_skeleton=False):
    """(the figure after Match Markers with a take of markers at `places` (m, 3) or (f, m, 3), its scale)."""
    shape = figure_body.body(spacing=0.03)
    obj = meshes.make_object(shape.vertices, shape.quads.tolist(), "Figure")
    path = take_files.write_trc(tmp_path / "take.trc", names, places if np.ndim(places) == 3 else places + GO)
    take_files.bring_in(path, unit='METRES').meanvalue.is_skeleton = is_skeleton
    match()
    return obj, np.cbrt(np.linalg.det(np.reshape(obj.meanvalue.capture.alignment, (4, 4))[:3, :3]))


@pytest.mark.parametrize(("person", "prop", "shape", "at", "goes"), [
    ("actor:", "crate:", CRATE, (1.0, 0.3, 0.0), 0),
    ("", "box", CRATE, (0.12, -0.5, 0.0), 0),  # beside a foot, at first
    ("", "box", CRATE, (0.9, 0.3, 0.0), 1),
    ("actor:", "other:", REST, (0.3, 0.5, 0.0), 1),
    ("P1_", "P2_", REST, (0.3, 0.5, 0.0), -1),
    ("?", "??", REST, (1.2, 0.0, 0.0), -1),  # no name is known
])  # fmt: skip
def test_props_and_other_persons_get_no_handles_and_are_named(tmp_path, capfd, person, prop, shape, at, goes):
    own, others = [person + name for name in NAMES], [prop + name for name in NAMES[: len(shape)]]
    places = np.concatenate([REST + GO, shape + np.array(at) + goes * GO], axis=1)
    obj, _ = matched(tmp_path, [*own, *others], places)
    assert {handle.marker for handle in obj.meanvalue.handles} - {""} == set(own)
    (said,) = [line for line in capfd.readouterr().out.splitlines() if "No handle for" in line]
    assert f"{len(shape)} markers" in said and all(f"'{name}'" in said for name in others[:3])


@pytest.mark.parametrize("known", ["HandL", "Neck", "LeftFoot"])
def test_one_known_name_does_not_drop_the_others(tmp_path, known):
    obj, scale = matched(tmp_path, [known, *(f"M{k}" for k in range(40))], REST)
    assert len(obj.meanvalue.handles) == 41 and scale == pytest.approx(1.0, abs=0.06)


def test_what_is_found_in_videos_are_joints_inside_of_the_body(tmp_path):
    obj, scale = matched(tmp_path, [*JOINTS, *POINTS, "Jaw"], np.array([*VIDEO, VIDEO[0]]))
    assert len(obj.meanvalue.handles) == 18 and scale == pytest.approx(1.0, abs=0.08)
    for name in JOINTS:
        pair = obj.meanvalue.capture.pairs[name]
        joint = obj.data.vertices[pair.vertex].co + Vector(pair.offset)
        _, point, normal, _ = obj.closest_point_on_mesh(joint)
        assert (joint - point).dot(normal) < 0.005, name


def test_of_a_skeleton_known_joints_alone_get_handles(tmp_path):
    names = ["bone_1" if name == "Neck" else name.replace("Hip", "Thigh") for name in JOINTS]
    obj, _ = matched(tmp_path, [*names, "thumb"], np.array([*VIDEO[:13], VIDEO[6]]), True)
    assert {handle.name for handle in obj.meanvalue.handles} == {*names} - {"bone_1"}
    assert bpy.ops.meanvalue.pick_marker_point(marker="thumb", vertex=100) == {'FINISHED'}
    match()
    assert "thumb" in obj.meanvalue.handles and "bone_1" not in obj.meanvalue.handles
    obj.meanvalue.capture.pairs["thumb"].is_picked = False
    for number, pair in enumerate(obj.meanvalue.capture.pairs):
        pair.name = f"bone_{number}"
    for number, empty in enumerate(obj.meanvalue.capture.take.objects):
        empty.meanvalue.marker = f"bone_{number}"
    with steps.refused("None of 14 joints has a known place"):
        match()


@pytest.mark.parametrize(("is_leg", "is_named"), [(True, False), (True, True), (False, True)])
def test_a_part_of_a_person_keeps_its_size_and_what_nothing_holds_is_told(tmp_path, capfd, is_leg, is_named):
    rows = [k for k, name in enumerate(NAMES) if (name[0] == "L" and REST[k, 2] < 0.8 if is_leg else REST[k, 2] > 0.85)]
    obj, scale = matched(tmp_path, [NAMES[k] if is_named else f"M{k}" for k in rows], REST[rows])
    assert 0.9 < scale < 1.2 and len(obj.meanvalue.handles) >= len(rows)
    said = capfd.readouterr().out
    assert f"Nothing holds {'arms and legs' if is_leg else 'legs'}" in said and f"scaled by {scale:.3g}" in said


@pytest.mark.parametrize("side, words", [(1.0, "Nothing holds legs to their ends"), (-1.0, "feet point backward")])
def test_a_leg_without_markers_below_its_knee_and_what_is_mirrored_are_told(tmp_path, capfd, side, words):
    rows = [k for k, name in enumerate(NAMES) if side < 0.0 or name[0] == "R" or REST[k, 2] > 0.12]
    matched(tmp_path, [NAMES[k] for k in rows], REST[rows] * [side, 1.0, 1.0])
    assert words in capfd.readouterr().out


@pytest.mark.parametrize("lean", [0.0, 0.46, 1.57])
def test_who_sits_leans_or_lies_throughout_is_as_high_as_captured(tmp_path, capfd, lean):
    seated = sitting_figure.take(220).clean[210] @ walking_figure.turn_x(np.array(lean)).T
    seated += [0.0, 0.0, 0.25 - seated[:, 2].min()]  # on the footrest of a chair that rolls
    obj, scale = matched(tmp_path, NAMES, seated)
    pelvis = [pair for pair in obj.meanvalue.capture.pairs if pair.name.startswith("Waist")]
    off = [pair.control.matrix_world.translation.z - seated[NAMES.index(pair.name), 2] for pair in pelvis]
    assert abs(np.mean(off)) < 0.03, "0.12 to 0.46 with the trunk where the mesh has it"
    soles = [pair.control.matrix_world.translation.z - obj.data.vertices[pair.vertex].co.z
             for pair in obj.meanvalue.capture.pairs if pair.name in walking_figure.FOOT_LABELS["L"]]  # fmt: skip
    assert lean or np.mean(soles) == pytest.approx(0.22, abs=0.012), "0.09 too low by the length of legs that are bent"
    assert scale == pytest.approx(1.0, abs=0.06)
    alignment = obj.meanvalue.capture.alignment
    assert abs(np.arctan2(alignment[4], alignment[0])) < np.radians(10.0), "49 where bent legs tell the way"
    assert "feet point backward" not in capfd.readouterr().out


def test_who_climbs_down_stairs_has_his_size(tmp_path):
    _, scale = matched(tmp_path, NAMES, walking_figure.take(160, drop=0.34).clean)
    assert scale == pytest.approx(1.0, abs=0.06), "0.83 with each leg as low as it stands later"
