# SPDX-License-Identifier: GPL-3.0-or-later
"""A generated figure and its generated walk, from the files to handles on the body, by the operators."""

import bpy
import numpy as np
import pytest
from support import body_mesh, marked_tube, meshes, steps, take_files, walking_figure

pytestmark = pytest.mark.slow

FRAMES = 120


def set_up(tmp_path, legs=1.0, **walk):
    """(body, its bones): a turned, moved and bigger body with the T-pose and the walk imported."""
    vertices, triangles, bones = body_mesh.body(legs)
    obj = meshes.make_object(vertices.tolist(), triangles.tolist(), "Body")
    obj.location, obj.rotation_euler, obj.scale = (2.0, 1.0, 0.0), (0.0, 0.0, 1.2), (1.3, 1.3, 1.3)
    bpy.context.view_layer.update()
    still, moving = walking_figure.t_pose(frames=5), walking_figure.take(frames=FRAMES, **walk)
    for name, figure in (("walk", moving), ("standing", still)):
        path = take_files.write_trc(tmp_path / f"{name}.trc", figure.labels, figure.positions, figure.rate_hz)
        take_files.bring_in(path, unit='METRES')
    capture = obj.meanvalue.capture
    assert capture.take.name == "walk"
    capture.reference_take = bpy.data.collections["standing"]
    return obj, bones


def controls_at(obj, sample):
    """(m, 3) in the object's space."""
    marked_tube.at_sample(sample)
    world = np.array([pair.control.matrix_world.translation for pair in obj.meanvalue.capture.pairs])
    to_object = np.linalg.inv(np.array(obj.matrix_world))
    return world @ to_object[:3, :3].T + to_object[:3, 3]


def cuff_handles(obj):
    return [handle for handle in obj.meanvalue.handles if handle.cuff]


def cuff_places(obj, part, sample):
    """{cuff: (rest (k, 3), now (k, 3))} of the vertices of cuffs, in the object's space."""
    controls_at(obj, sample)
    rest = np.array([vertex.co for vertex in obj.data.vertices])
    move, apply = part("posing.bridge.control_places").move, part("scene.core.motion").apply
    held = {handle.cuff: (rest[steps.held(obj, handle.name)], move(obj, handle)) for handle in cuff_handles(obj)}
    return {name: (places, apply(move, places)) for name, (places, move) in held.items()}


def test_shanks_have_cuffs_that_go_where_the_bone_takes_them(tmp_path, part):
    obj, bones = set_up(tmp_path, gaps=0.05, noise=0.001)
    capture = obj.meanvalue.capture
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}
    assert {"shank.L cuff", "shank.R cuff"} <= {handle.cuff for handle in cuff_handles(obj)}
    assert all(handle.follows == 'CONTROL' and handle.is_soft for handle in cuff_handles(obj))
    vertices = np.array([vertex.co for vertex in obj.data.vertices])
    for sample in (37, 80):
        truth = body_mesh.posed(vertices, bones, np.array([sample]) / walking_figure.RATE_HZ)[0]
        for name, (rest, now) in cuff_places(obj, part, sample).items():
            indices = [int(np.linalg.norm(vertices - place, axis=1).argmin()) for place in rest]
            assert np.linalg.norm(now - truth[indices], axis=1).max() < 0.05, (name, sample)
    chosen = cuff_handles(obj)[0]
    chosen.strength = 0.25
    controls = {handle.cuff: handle.control for handle in cuff_handles(obj)}
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}
    assert {handle.cuff: handle.control for handle in cuff_handles(obj)} == controls, "used again"
    assert cuff_handles(obj)[0].strength == 0.25
    capture.keep_floor, count = False, len(bpy.data.objects)
    for name in ("LThigh", "RThigh", "LShin", "RShin"):  # the others do not tell how a thigh or shank turns
        capture.pairs[name].is_used = False
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}
    assert not cuff_handles(obj) and len(obj.meanvalue.handles) == 37
    assert len(bpy.data.objects) == count - len(controls) - 4


def test_cuffs_of_an_unevenly_scaled_object_are_rigid_in_the_world(tmp_path, part):
    obj, _bones = set_up(tmp_path)
    obj.scale = (1.3, 1.1, 1.4)
    bpy.context.view_layer.update()
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}
    to_world = np.array(obj.matrix_world)[:3, :3]
    turned = 0.0
    for sample in (0, 45, 90):
        places = cuff_places(obj, part, sample)
        assert places
        for rest, now in places.values():
            before, after = (np.diff(points, axis=0, append=points[:1]) @ to_world.T for points in (rest, now))
            lengths = np.linalg.norm(before, axis=1)
            assert np.abs(np.linalg.norm(after, axis=1) / lengths - 1.0).max() < 1e-4
            turned = max(turned, np.linalg.norm(after - before, axis=1).max() / lengths.max())
    assert turned > 0.2
