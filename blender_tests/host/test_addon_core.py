# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/core/: plain Python, run without Blender."""

import contextlib
import pathlib
import types

import numpy as np
import pytest
from support import bent_tubes

from addon.errors import CacheError, SceneError
from addon.posing.core import joints, segments
from addon.posing.core.bind_input import BindInput, anchor_layout, spring_strengths
from addon.scene.core import motion, whole_files
from addon.scene.core.point_sets import require_finite
from addon.solver.core import fingerprint, result
from addon.solver.session import DeformerCache
from native.benchmarks.rigid import rotation_about


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


def changed(name, index, value):
    array = getattr(square(), name).copy()
    array[index] = value
    return square(**{name: array})


@pytest.mark.parametrize(
    "after, words",
    [
        (changed("rest", (4, 2), np.nextafter(np.float32(0.1), np.float32(1.0))), "the rest shape was edited"),
        (changed("face_corners", 0, 8), "the faces were changed"),
        (square(face_starts=np.array([0, 4, 8], np.int32)), "the faces were changed"),
        (changed("anchors", 2, 8), ""),
        (square(anchors=np.array([0, 2, 6, 8], np.int32)), ""),
        (changed("roi", 7, False), ""),
        (square(method="fast"), ""),
        (square(rest=np.zeros((10, 3), np.float32), roi=np.ones(10, bool)), "the mesh has 10 vertices (9 when bound)"),
    ],
)
def test_each_change_tells_and_the_artist_looks_at_those_of_the_mesh(after, words):
    assert square().fingerprint == square().fingerprint != after.fingerprint
    assert fingerprint.changes(square().fingerprint, after.fingerprint) == words
    assert fingerprint.changes(after.fingerprint, after.fingerprint) == ""


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


# -- what can be bound -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_every_kind_of_bad_number_is_found(value):
    positions = np.zeros((5, 3), np.float32)
    require_finite(positions, "thing")
    positions[3, 2] = value
    with pytest.raises(SceneError, match=r"1 vertex of the thing .the first is 3."):
        require_finite(positions, "thing")


def test_anchors_are_sorted_and_belong_to_the_first_group_that_has_them():
    union, pieces = anchor_layout([np.array([5, 1], np.int32), np.array([1, 3], np.int32), np.empty(0, np.int32)])
    assert (union.tolist(), pieces.tolist()) == ([1, 3, 5], [0, 1, 0])
    assert union.dtype == pieces.dtype == np.int32


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
        components=components,
        carriers=[carrier[0] if carrier else -1 for _free, _left, *carrier in parts],
        part_of=[*range(len(parts)), -1],
    )


def unheld(*parts):
    return list(result.unheld_notes(report(*parts), np.arange(len(parts) + 1)))


def test_parts_that_are_not_held():
    assert "2 parts of the mesh have fewer than three fixed points" in unheld((10, 0), (5, 4), (0, 7), (5, 1))[0]
    assert "1 part of the mesh has" in unheld((10, 0), (5, 7, 0), (6, 7, 0), (5, 4))[0]
    assert not result.nothing_is_held(report((10, 0), (5, 4)))
    assert result.nothing_is_held(report((10, 1), (5, 4), (0, 0)))
    assert unheld((10, 0), (0, 7)) == []


# -- cache -----------------------------------------------------------------------------------------------------------


def test_bytes_are_limited_but_the_newest_stays():
    cache = DeformerCache(capacity=9, byte_limit=100)
    cache.put("a", 1, 60)
    cache.put("b", 2, 60)
    assert [cache.get(key) for key in "ab"] == [None, 2]
    cache.put("c", 3, 500)
    assert [cache.get(key) for key in "bc"] == [None, 3]


# -- what a solve tells ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("moved", "warnings"), [([1], 0), ([], 1), ([0, 1], 1)])
def test_poses_that_move_no_handle_or_one_outside_the_region_are_told(moved, warnings):
    bind_input = square(anchors=np.array([0, 1]), roi=np.arange(9) % 3 > 0, handles=np.zeros(2, np.int32))
    pose = bind_input.rest.copy()
    pose[moved] += 1.0
    assert len(list(result.pose_warnings(bind_input, pose[bind_input.anchors]))) == warnings


# -- springs ---------------------------------------------------------------------------------------------------------


def test_a_spring_is_shared_out_among_the_vertices_of_its_handle():
    pieces = np.array([0, 1, 1, 2, 1, 1])
    strengths = spring_strengths(pieces, [None, 0.5, None], 15.0)
    assert np.isinf(strengths[[0, 3]]).all()
    assert strengths[pieces == 1].sum() == pytest.approx(6.0)
    stronger = spring_strengths(pieces, [None, 0.75, None], 15.0)
    assert (stronger[pieces == 1] > 5.0 * strengths[pieces == 1]).all()


# -- which poses differ most -------------------------------------------------------------------------------------------


def bent(angle, turn=0.0):
    """(20, 3): a line along x, bent in its middle, and turned as a whole."""
    x = np.linspace(-1.0, 1.0, 20)
    points = np.stack([np.where(x < 0.0, x, x * np.cos(angle)), np.where(x < 0.0, 0.0, x * np.sin(angle)), 0.0 * x], 1)
    return points @ rotation_about((0, 0, 1), np.degrees(turn)).T + turn


@pytest.mark.parametrize(("strengths", "told"), [(None, True), (np.array([np.inf, 1.0, 1.0]), False)])
def test_handles_in_one_place_are_told_of_where_they_are_to_be_met(strengths, told):
    copies = np.array([0, 1, 2, 3, 4, 5, 2, 7, 8], np.int32)
    settings = {"method": "fast", "rigidity": 15.0, "handles": np.arange(3, dtype=np.int32)}
    same = square(**settings, copies=copies, strengths=strengths)
    targets = same.anchor_rest + np.array([[0.0], [1.0], [-1.0]])
    assert any("in one place" in note for note in result.torn_notes(same, targets)) == told


def test_the_farthest_come_first_and_those_alike_not_at_all():
    poses = np.array([bent(angle, 3.0 * angle) for angle in (0.0, 0.4, 1.5, 1.5, -1.0, 0.01)])
    assert motion.differing(bent(0.0), poses, 1, 0.02) == [2]
    assert motion.differing(bent(0.0), poses, 2, 0.02) == [2, 4]
    assert motion.differing(bent(0.0), poses, 9, 0.02) == [1, 2, 4]
    assert motion.differing(bent(0.0), poses[:1], 9, 0.02) == []


# -- segments ----------------------------------------------------------------------------------------------------------


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
    assert sum(len(way) > 1 for way in segments.ways_up(parents, found, set.union(*named))) == len(named) - 1


def test_limbs_are_where_one_segment_has_most_of_the_weight():
    vertices = np.arange(4)
    upper, twist, lower = np.array([(0.5, 0.3, 0.6, 0.0), (0.5, 0.3, 0.2, 0.0), (0.0, 0.6, 0.2, 0.0)])
    of_bones = {"upper": [(vertices, upper), (vertices, twist)], "lower": [(vertices, lower)]}
    found, part_of, is_whole = joints.by_weights(np.zeros((4, 3)), of_bones)
    assert part_of.tolist() == [0, 0, 0, -1] and is_whole.tolist() == [True, False, True, False]
    assert found[0] == joints.STIFF and found[1] == found[3] == 1.0 and 10.0 < found[2] < 25.0


def test_a_bent_joint_goes_on_as_it_is_bent_and_a_straight_one_as_it_is_told():
    forward, top, bottom = np.array((0.0, -1.0, 0.2)), np.array((0.0, 0.0, 2.0)), np.zeros(3)
    for x, y, told, way in (
        (0.0, 0.0, forward, (0, -1, 0)),
        (0.0, 0.3, forward, (0, 1, 0)),
        (0.3, 0.0, None, (1, 0, 0)),
    ):
        along, found = joints.hinge(top, np.array((x, y, 1.0)), bottom, told)
        assert np.allclose(along, (0, 0, -1)) and np.allclose(found, way)
    assert joints.hinge(top, np.array((0.0, 0.0, 1.0)), bottom, None) is None
    assert joints.hinge(top, np.array((0.0, 0.0, 1.0)), bottom, top) is None
    assert joints.hinge(top, np.array((0.0, 0.0, 1.0)), np.array((0.0, -0.1, 1.0)), top) is None  # a kneecap
    assert joints.hinge(top, top, top, top) is None


def test_knees_and_elbows_are_known_by_their_names():
    parents = {"spine": "", "thigh.L": "spine", "shin.L": "thigh.L", "foot.L": "shin.L", "toe.L": "foot.L"}
    parents |= {"upper_arm.L": "spine", "forearm.L": "upper_arm.L", "hand.L": "forearm.L", "forefoot.L": "hand.L"}
    parents |= {"kneecap.L": "shin.L", "patch.L": "kneecap.L", "tail_upper": "spine", "tail_lower": "tail_upper"}
    parents |= {"tail_tip": "tail_lower", "spine_lower": "spine", "spine_mid": "spine_lower"}
    found = {lower: (upper, ends) for upper, lower, ends in segments.hinges(parents, segments.of(parents))}
    assert found == {"shin.L": ("thigh.L", ["foot.L", "kneecap.L"]), "forearm.L": ("upper_arm.L", ["hand.L"])}
    assert segments.is_arm("forearm.L") and not segments.is_arm("shin.L")


def test_kept_poses_tell_where_a_limb_bends():
    rest, faces = bent_tubes.tube(1200)
    corners, starts = np.array(faces).ravel(), np.arange(len(faces)) * len(faces[0])
    poses = [bent_tubes.posed(rest, [(0.5 * np.ptp(rest[:, 2]), axis, 90.0)], 0.6) for axis in ((1, 0, 0), (0, 1, 0))]
    found = joints.by_poses(rest, corners, starts, poses)
    off = np.abs(rest[:, 2] - rest[:, 2].mean()) / np.ptp(rest[:, 2])
    assert found[off < 0.03].mean() < 0.25 * joints.STIFF and found[off > 0.25].min() > 0.9 * joints.STIFF


# -- names of files ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("Tube", "Tube"),
        ("CON", "CON_"),
        ("nul", "nul_"),
        ("Com1.chunks", "Com1_.chunks"),
        ("CONE", "CONE"),
        ("Walk.001", "Walk.001"),
        ("Walk...", "Walk"),
        ("Walk. ", "Walk"),
        ("a:b", "a_b"),
        ("a\0b\n", "a_b_"),
        ("...", "_"),
        ("手", "手"),
    ],
)
def test_names_that_every_system_takes(name, expected):
    assert whole_files.file_name(name) == expected
    assert whole_files.file_name(expected) == expected
    assert not pathlib.PureWindowsPath(expected + ".pc2").is_reserved()


def open_elsewhere(times, monkeypatch):
    """Renames fail so often, as they do on Windows while a program has the file open."""
    rename, failures = pathlib.Path.replace, [32] * times
    monkeypatch.setattr(whole_files.time, "sleep", lambda _seconds: None)

    def replace(self, target):
        if failures:
            error = PermissionError(13, "The process cannot access the file")
            error.winerror = failures.pop()
            raise error
        return rename(self, target)

    monkeypatch.setattr(pathlib.Path, "replace", replace)


def write(path, content):
    with whole_files.replacing(path) as file:
        file.write(content)


@pytest.mark.parametrize("times, left", [(3, b"new"), (100, b"old")])
def test_a_file_that_is_open_elsewhere_is_waited_for_and_left_as_it_is_at_last(tmp_path, monkeypatch, times, left):
    write(tmp_path / "a", b"old")
    open_elsewhere(times, monkeypatch)
    refused = pytest.raises(CacheError, match="another program has it open")
    with refused if left == b"old" else contextlib.nullcontext():
        write(tmp_path / "a", b"new")
    assert (tmp_path / "a").read_bytes() == left
    assert [path.name for path in tmp_path.iterdir()] == ["a"]
