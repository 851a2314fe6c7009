# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/capture: names of markers; without Blender."""

import numpy as np
import pytest

from addon.capture.core import body, landmarks, marker_sets, readers
from blender_tests.support import mesh_files, walking_figure


def test_the_generated_figure_has_the_common_41_markers():
    found = marker_sets.recognise(walking_figure.LABELS)
    assert None not in found.landmarks
    assert found.landmarks[walking_figure.LABELS.index("RKneeOut")] == "knee.R"


@pytest.mark.parametrize("marker_set", marker_sets.BUILT_IN)
def test_built_in_sets_are_sound(marker_set):
    names = {place for places in marker_set.values() for place in places.split()}
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
    for spelled in ("LASI", "Subject:LASI", "a:b:lasi", "L_ASI", "LASIS", "LFWT", "L.ASIS_study", "L_IAS", "Me_Hip1"):
        assert marker_sets.recognise([spelled]).landmarks == ("pelvis.front.L",)
    for prefix in ("Skeleton_", "Skeleton 001_", "J_Bip_", "take1"):
        found = marker_sets.recognise([*(prefix + label for label in walking_figure.LABELS), "Crate:1", "Crate:2"])
        assert None not in found.landmarks[:-2]


#: Sides, names of pelvis and neck, and of a clavicle, an arm and a leg.
SKELETONS = {
    "Mixamo": ("Left Right", "Hips Neck", "*Shoulder *Arm *ForeArm *Hand *UpLeg *Leg *Foot *ToeBase *HandMiddle1"),
    "SMPL": ("L_ R_", "Pelvis Neck", "*Collar *Shoulder *Elbow *Wrist *Hip *Knee *Ankle *Foot *Hand"),
    "MakeHuman": ("L R", "Hips Neck", "Clavicle_* UpArm_* LoArm_* Hand_* UpLeg_* LoLeg_* Foot_* Toe_* Middle1_*"),
    "Poser": ("l r", "hip neck", "*Collar *Shldr *ForeArm *Hand *Thigh *Shin *Foot *Toe"),
    "Cats": ("Left_ Right_", "Hips Neck", "*shoulder *arm *elbow *wrist *leg *knee *ankle *toe"),
    "Phone": ("left_ right_", "hips_joint neck_1_joint", "*shoulder_1_joint *arm_joint *forearm_joint *hand_joint "
              "*upLeg_joint *leg_joint *foot_joint *toes_joint"),
    "Motive": ("L R", "Hip neck_1", "*Shoulder *UArm *FArm *Hand *Thigh *Shin *Foot *Toe"),
    "iPi": ("L R", "Hip Neck", "*Clavicle *Shoulder *Forearm *Hand *Thigh *Shin *Foot *Toe"),
    "VRM": ("L_ R_", "C_Hips C_Neck", "*Shoulder *UpperArm *LowerArm *Hand *UpperLeg *LowerLeg *Foot *ToeBase"),
}  # fmt: skip
ORDER = "clavicle.joint* shoulder.joint* elbow.joint* wrist.joint* hip* knee.joint* ankle.joint* toe.joint* hand.joint*"


@pytest.mark.parametrize("maker", SKELETONS)
@pytest.mark.parametrize("prefix", ["", "mixamorig:", "J_Bip_", "mixamorig"])
def test_joints_of_skeletons_are_known(maker, prefix):
    sides, middle, names = SKELETONS[maker]
    labels = [*middle.split(), *(name.replace("*", side) for side in sides.split() for name in names.split())]
    places = [name.replace("*", side) for side in (".L", ".R") for name in ORDER.split()[: len(names.split())]]
    found = marker_sets.recognise([prefix + label for label in labels]).landmarks
    assert found == ("pelvis.joint", "neck.joint", *places) and landmarks.has_joints(found)


def test_a_joint_called_as_the_set_has_it_goes_before_its_helper():
    labels = ["Hips", "__UpLeg_L", "UpLeg_L", "LoLeg_L", "UpLeg_R", "LoLeg_R", "Foot_L", "Foot_R"]
    assert marker_sets.recognise(labels).landmarks[1:3] == (None, "hip.L")


@pytest.mark.parametrize(("gone", "limbs"), [
    ((), []), (("LElbowOut",), ["arms"]), (("RShoulderTop", "LKneeOut"), ["arms", "legs"]),
    (("WaistRFront",), ["legs"]), (walking_figure.LABELS, ["arms", "legs"]),
])  # fmt: skip
def test_limbs_without_landmarks_are_told(gone, limbs):
    known = marker_sets.recognise(walking_figure.LABELS).landmarks
    left = [None if label in gone else name for label, name in zip(walking_figure.LABELS, known, strict=True)]
    assert landmarks.unknown_limbs(left) == limbs
    assert not landmarks.has_joints(known)


def test_a_known_name_vouches_for_a_marker_that_is_not_far_away():
    distances, names = np.array([0.0, 0.2, 0.6, 0.3, 0.2]), ("heel.L", "toe.L", "knee.L", None, None)
    assert [body.far(each, names, is_posed=True) for each in (distances, distances + 0.5)] == [[2, 3], []]


def test_a_landmark_is_given_once_and_unknown_names_are_none():
    found = marker_sets.recognise(["LASI", "LASIS", "RASI", "*35", "LKNE"])
    assert found.landmarks == ("pelvis.front.L", None, "pelvis.front.R", None, "knee.L")
    assert [marker_sets.recognise(names) for names in (["*1", "LASIX"], [])] == [((None, None), ()), ((), ())]


@pytest.mark.parametrize(
    ("file", "known"), [("pig-walk/PiG_Motion-FlatFoot-One.c3d", 35), ("rajagopal/motion_capture_walk.trc", 41)]
)
def test_real_takes_are_recognised(file, known):
    path = mesh_files.path_of(f"mocap/{file}")
    found = marker_sets.recognise(readers.read(path).labels)
    assert len(set(found.landmarks) - {None}) == known == len(found.landmarks)
