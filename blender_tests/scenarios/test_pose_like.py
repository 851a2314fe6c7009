# SPDX-License-Identifier: GPL-3.0-or-later
"""Pose Like: a mesh bends as its own shape keys show."""

import bpy
import numpy as np
import pytest
from support import farm, meshes, steps
from support.baking import save
from support.bent_tubes import elbow

RINGS, SEGMENTS = 33, 8


def bent(rest, angle):
    return elbow(rest, angle, 2.4)


@pytest.fixture
def limb():
    """A tube with two keys in which it is bent; pins at its root, a handle at its end, moved as if bent in between."""
    obj = meshes.tube(RINGS, SEGMENTS)
    rest = np.array([tuple(vertex.co) for vertex in obj.data.vertices])
    steps.add_key(obj, "Forth", bent(rest, 1.5))
    steps.add_key(obj, "Back", bent(rest, -1.2))
    steps.add_handle(obj, "Root", range(2 * SEGMENTS), pin=True)
    steps.add_key(obj, "Asked", bent(rest, 1.0)).mute = True
    end = range((RINGS - 2) * SEGMENTS, RINGS * SEGMENTS)
    steps.add_handle(obj, "End", end, pin=True)
    return obj


def solve(obj):
    """How far the result is from the true shape, at the mean."""
    steps.run(obj, "solve_from_key", key="Asked")
    off = steps.key_positions(obj, "Mean-Value") - steps.key_positions(obj, "Asked")
    return np.linalg.norm(off, axis=1).mean()


def test_a_limb_bends_as_its_keys_show(limb):
    alone = solve(limb)
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    assert solve(limb) < 0.75 * alone
    limb.meanvalue.pose_like = 'NOTHING'
    assert solve(limb) == pytest.approx(alone, rel=1e-3)


def test_what_is_no_example_is_told_by_name(limb):
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    steps.add_key(limb, "Idle", steps.key_positions(limb, "Basis"))  # without effect: left out
    solve(limb)
    steps.add_key(limb, "Twin", steps.key_positions(limb, "Back"))
    with steps.refused("'Twin'", "'Back'", "Mute"):
        bpy.ops.meanvalue.bind()
    for name in ("Forth", "Back", "Twin"):
        limb.data.shape_keys.key_blocks[name].mute = True
    with steps.refused("no shape key", "Pose Like"):
        bpy.ops.meanvalue.bind()
    limb.data.shape_keys.key_blocks["Back"].mute = False
    limb.meanvalue.method = 'full'
    with steps.refused("method Fast"):
        bpy.ops.meanvalue.bind()


def test_a_vertex_group_masks_its_key(limb):
    group = steps.add_group(limb, "Nobody", [0], 0.0)
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    for name in ("Forth", "Back"):
        limb.data.shape_keys.key_blocks[name].vertex_group = group.name
    with steps.refused("no shape key"):
        bpy.ops.meanvalue.bind()


def test_a_farm_bakes_it(limb, tmp_path):
    steps.add_handle(limb, "Middle", range(16 * SEGMENTS, 17 * SEGMENTS), live=False).location.x += 0.3
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    bpy.context.scene.frame_end = 3
    meshes.activate(limb)
    save(tmp_path)
    out = farm.planned(tmp_path)
    assert [farm.run(what, "--plan", out / "plan", "--index", 0) for what in ("bake", "merge")] == [0, 0]
    assert (out / limb.name / f"{limb.name}.pc2").read_bytes() == farm.baked_at_once(tmp_path, limb.name)


def test_with_merged_vertices_and_a_plane_of_symmetry(limb):
    limb.meanvalue.symmetric = 'X'
    limb.meanvalue.merge_distance = 1e-4
    alone = solve(limb)
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    assert solve(limb) < 0.75 * alone


def arms(rest, upper, lower):
    """Two limbs along z that meet at 0, each bent about x in its middle."""
    down, mirror = rest[:, 2] < 0.0, (1.0, 1.0, -1.0)
    shape = rest.copy()
    shape[~down] = elbow(rest[~down], upper, 1.2)
    shape[down] = elbow(rest[down] * mirror, lower, 1.2) * mirror
    return shape


def test_one_arm_is_an_example_for_both_where_they_are_symmetric():
    obj = meshes.tube(RINGS, SEGMENTS)
    rest = np.array([tuple(vertex.co) for vertex in obj.data.vertices])
    rest[:, 2] -= 0.5 * (rest[:, 2].min() + rest[:, 2].max())
    obj.data.vertices.foreach_set("co", rest.astype(np.float32).ravel())
    one = steps.add_key(obj, "One Arm", arms(rest, 1.5, 0.0))
    mean = steps.add_key(obj, "Mean", 0.5 * (arms(rest, 1.5, 0.0) + arms(rest, 0.0, 1.5)))
    steps.add_key(obj, "Asked", arms(rest, 1.0, 1.0)).mute = True
    middle = RINGS // 2 * SEGMENTS
    steps.add_handle(obj, "Middle", range(middle - SEGMENTS, middle + 2 * SEGMENTS), pin=True)
    steps.add_handle(obj, "End", range((RINGS - 2) * SEGMENTS, RINGS * SEGMENTS), pin=True)
    obj.meanvalue.symmetric = 'Z'
    alone = solve(obj)
    obj.meanvalue.pose_like = 'SHAPE_KEYS'
    one.mute = True
    with_mean = solve(obj)
    one.mute, mean.mute = False, True
    with_one = solve(obj)
    print(f"alone {alone:.4f}, the mean {with_mean:.4f}, one arm {with_one:.4f}")
    assert with_one < 0.75 * min(alone, with_mean)
    other = steps.add_key(obj, "Other Arm", arms(rest, 0.0, 1.5))  # its image is there already
    assert solve(obj) == pytest.approx(with_one, rel=0.02)
    other.data.foreach_set("co", arms(rest, 1.5, 0.0).astype(np.float32).ravel())
    obj.data.update_tag()
    with steps.refused("'One Arm'", "'Other Arm'"):
        bpy.ops.meanvalue.bind()


def test_live_follows_an_edited_key(limb):
    limb.meanvalue.pose_like = 'SHAPE_KEYS'
    meshes.activate(limb)
    control = steps.add_handle(limb, "Middle", range(16 * SEGMENTS, 17 * SEGMENTS))
    limb.meanvalue.live = True
    control.location.y += 0.5
    bpy.context.view_layer.update()
    before = steps.key_positions(limb, "Mean-Value")
    assert np.abs(before - steps.key_positions(limb, "Basis")).max() > 0.4
    limb.data.shape_keys.key_blocks["Forth"].mute = True
    limb.update_tag()
    bpy.context.view_layer.update()
    assert np.abs(steps.key_positions(limb, "Mean-Value") - before).max() > 0.0
