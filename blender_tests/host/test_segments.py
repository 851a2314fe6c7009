# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of well-known rigs are one segment, and where that has a mesh bend."""

import numpy as np
import pytest
from support import bent_tubes

from addon.posing.core import joints, segments

#: Bones after their parents; what is between bars is one segment, each of the others is one of its own.
RIGS = {
    "MakeHuman": """root - | spine02 root | spine01 spine02 | pelvis.L root | breast.L spine02; clavicle.L spine01;
        upperarm01.L clavicle.L | upperarm02.L upperarm01.L; lowerarm01.L upperarm02.L | lowerarm02.L lowerarm01.L;
        wrist.L lowerarm02.L | metacarpal1.L wrist.L; finger2-1.L metacarpal1.L; finger2-2.L finger2-1.L;
        neck01 spine01 | neck02 neck01; head neck02 | jaw head | eye.L head; upperleg01.L pelvis.L""",
    "Rigify": """DEF-spine root | DEF-spine.001 DEF-spine; ORG-spine.001 root; ORG-shoulder.L ORG-spine.001;
        DEF-shoulder.L ORG-shoulder.L; DEF-upper_arm.L ORG-shoulder.L | DEF-upper_arm.L.001 DEF-upper_arm.L;
        DEF-spine.002 DEF-spine.001; DEF-spine.003 DEF-spine.002 | DEF-face DEF-spine.003""",
    "Rigify horse": """spine.001 - | spine.006 spine.001; neck.001 spine.006 | neck.002 neck.001; tail.001 spine.001;
        tail.002 tail.001; shoulder.L spine.001; thigh.L spine.001; lower_leg.L thigh.L; r_hoof.L lower_leg.L""",
    "Mixamo": """m:Hips - | m:Spine m:Hips | m:Spine1 m:Spine; m:LeftShoulder m:Spine1;
        m:LeftArm m:LeftShoulder | m:LeftArmTwist m:LeftArm; m:LeftForeArm m:LeftArm; m:LeftHandIndex1 m:LeftForeArm;
        m:LeftHandIndex2 m:LeftHandIndex1; m:Head m:Spine1 | m:HeadTop_End m:Head; m:LeftUpLeg m:Hips""",
    "VRM": """J_Bip_C_Hips - | J_Bip_C_UpperChest J_Bip_C_Hips | J_Sec_L_Bust1 J_Bip_C_UpperChest;
        J_Bip_L_UpperArm J_Bip_C_UpperChest; J_Bip_L_LowerArm J_Bip_L_UpperArm; J_Bip_L_UpperLeg J_Bip_C_Hips;
        J_Bip_C_Head J_Bip_C_UpperChest | J_Adj_L_FaceEye J_Bip_C_Head; J_Sec_Hair1_01 J_Bip_C_Head""",
    "a fish, or a row of bones": "spine - ; spine.001 spine; spine.002 spine.001",
}


@pytest.mark.parametrize("name", RIGS)
def test_bones_that_move_as_one_are_one_segment(name):
    expected = [[bone.split() for bone in segment.split("|")] for segment in RIGS[name].split(";")]
    parents = {bone: parent.strip("-") if parent == "-" else parent for each in expected for bone, parent in each}
    parents.setdefault("root", "")
    found = segments.of(parents)
    named = [{found[bone] for bone, _parent in each} for each in expected if "ORG" not in each[0][0]]
    assert all(len(each) == 1 for each in named), named
    assert len(set.union(*named)) == len(named), named
    assert segments.joint_count(parents, found, set.union(*named)) == len(named) - 1


def test_limbs_are_where_one_segment_has_most_of_the_weight():
    vertices = np.arange(4)
    upper, twist, lower = np.array([(0.5, 0.3, 0.6, 0.0), (0.5, 0.3, 0.2, 0.0), (0.0, 0.6, 0.2, 0.0)])
    found = joints.by_weights(4, [[(vertices, upper), (vertices, twist)], [(vertices, lower)]])
    assert found[0] == joints.STIFF and found[1] == found[3] == 1.0 and 10.0 < found[2] < 25.0


def test_kept_poses_tell_where_a_limb_bends():
    rest, faces = bent_tubes.tube(1200)
    corners, starts = np.array(faces).ravel(), np.arange(len(faces)) * len(faces[0])
    poses = [bent_tubes.posed(rest, [(0.5 * np.ptp(rest[:, 2]), axis, 90.0)], 0.6) for axis in ((1, 0, 0), (0, 1, 0))]
    found = joints.by_poses(rest, corners, starts, poses)
    off = np.abs(rest[:, 2] - rest[:, 2].mean()) / np.ptp(rest[:, 2])
    assert found[off < 0.03].mean() < 0.25 * joints.STIFF and found[off > 0.25].min() > 0.9 * joints.STIFF
