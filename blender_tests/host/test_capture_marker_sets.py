# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: names of markers; without Blender."""

import numpy as np
import pytest

from addon.capture.core import known_sets, landmarks, marker_sets, on_body, readers
from blender_tests.support import mesh_files, walking_figure


def test_the_generated_figure_has_the_common_41_markers():
    found = marker_sets.recognise(walking_figure.LABELS)
    assert None not in found.landmarks
    assert found.landmarks[walking_figure.LABELS.index("RKneeOut")] == "knee.R"


@pytest.mark.parametrize("marker_set", known_sets.BUILT_IN)
def test_built_in_sets_are_sound(marker_set):
    names = set(marker_set.values())
    for landmark in names:
        assert landmarks.segments_of(landmark), landmark
        assert "?" not in "".join(landmarks.segments_of(landmark)), landmark
    assert set(marker_sets.recognise(list(marker_set)).landmarks) - {None} == names
    # Left and right mirror each other, and each foot is known.
    for landmark in names:
        side = landmarks.side_of(landmark)
        if side and landmark != "back.shoulder.R":  # Plug-in Gait's marker that tells left from right
            assert landmark[:-1] + {"L": "R", "R": "L"}[side] in names
    assert set(landmarks.feet(names)) == {"L", "R"}
    assert landmarks.unknown_limbs(names) == []


def test_prefixes_case_and_separators_do_not_matter():
    for spelled in ("LASI", "Subject:LASI", "a:b:lasi", "L_ASI", "l.asi", "LASIS", "LFWT", "L.ASIS_study"):
        assert marker_sets.recognise([spelled]).landmarks == ("pelvis.front.L",)
    for prefix in ("Skeleton_", "Skeleton 001_", "J_Bip_", "take1"):
        found = marker_sets.recognise([*(prefix + label for label in walking_figure.LABELS), "Crate:1", "Crate:2"])
        assert None not in found.landmarks[:-2]


MIXAMO = ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head", "HeadTop_End", *(
    side + name
    for side in ("Left", "Right")
    for name in ("Shoulder", "Arm", "ForeArm", "Hand", "HandMiddle1", "UpLeg", "Leg", "Foot", "ToeBase", "Toe_End")
))  # fmt: skip


@pytest.mark.parametrize("prefix", ["", "mixamorig:", "mixamorig_", "mixamorig"])
def test_joints_of_skeletons_are_known(prefix):
    found = marker_sets.recognise([prefix + label for label in MIXAMO])
    assert None not in found.landmarks
    places = dict(zip(MIXAMO, found.landmarks, strict=True))
    assert (places["LeftLeg"], places["RightArm"], places["LeftUpLeg"]) == ("knee.joint.L", "shoulder.joint.R", "hip.L")
    assert landmarks.unknown_limbs(found.landmarks) == []
    assert landmarks.has_joints(found.landmarks)


def test_a_joint_called_as_the_set_has_it_goes_before_its_helper():
    labels = ["Hips", "__UpLeg_L", "UpLeg_L", "LoLeg_L", "UpLeg_R", "LoLeg_R", "Foot_L", "Foot_R"]
    found = marker_sets.recognise(labels).landmarks
    assert (found[1], found[2]) == (None, "hip.L")
    smpl = marker_sets.recognise(["Pelvis", "L_Ankle", "L_Foot", "R_Foot", "L_Wrist", "L_Hand"], True).landmarks
    assert smpl[2:] == ("toe.joint.L", "toe.joint.R", "wrist.joint.L", "hand.joint.L")


@pytest.mark.parametrize(("gone", "limbs"), [
    ((), []), (("LElbowOut",), ["arms"]), (("RShoulderTop", "LKneeOut"), ["arms", "legs"]),
    (("WaistRFront",), ["legs"]), (walking_figure.LABELS, ["arms", "legs"]),
])  # fmt: skip
def test_limbs_without_landmarks_are_told(gone, limbs):
    known = marker_sets.recognise(walking_figure.LABELS).landmarks
    left = [None if label in gone else name for label, name in zip(walking_figure.LABELS, known, strict=True)]
    assert landmarks.unknown_limbs(left) == limbs
    assert not landmarks.has_joints(known)


@pytest.mark.parametrize("name", ["tpose", "walk1", "dance1"])
def test_joints_of_real_files_are_known(name):
    path = mesh_files.path_of(f"makehuman/{name}.bvh")
    assert landmarks.unknown_limbs(marker_sets.recognise(readers.read(path).labels).landmarks) == []


def test_a_known_name_vouches_for_a_marker_that_is_not_far_away():
    distances, names = np.array([0.0, 0.2, 0.6, 0.3, 0.2]), ("heel.L", "toe.L", "knee.L", None, None)
    assert [on_body.far(each, names, is_posed=True) for each in (distances, distances + 0.5)] == [[2, 3], []]


def test_a_landmark_is_given_once_and_unknown_names_are_none():
    found = marker_sets.recognise(["LASI", "LASIS", "RASI", "*35", "LKNE"])
    assert found.landmarks == ("pelvis.front.L", None, "pelvis.front.R", None, "knee.L")
    assert marker_sets.recognise(["*1", "LASIX"]) == ((None, None), ())
    assert marker_sets.recognise([]) == ((), ())


@pytest.mark.parametrize(
    ("file", "known"), [("pig-walk/PiG_Motion-FlatFoot-One.c3d", 35), ("rajagopal/motion_capture_walk.trc", 41)]
)
def test_real_takes_are_recognised(file, known):
    path = mesh_files.path_of(f"mocap/{file}")
    found = marker_sets.recognise(readers.read(path).labels)
    assert len(set(found.landmarks) - {None}) == known == len(found.landmarks)
