# SPDX-License-Identifier: GPL-3.0-or-later
"""Messy meshes as the artist meets them: parts without a handle follow, problems are counted and can be selected."""

import math

import bpy
import numpy as np
from support import baking, handles, heads, meshes, steps
from support.handles import rest, shown, update


def turn(control, degrees=60.0):
    control.rotation_mode = 'XYZ'
    control.rotation_euler = (0.0, 0.0, math.radians(degrees))
    update()


def distances(points):
    return np.linalg.norm(points[:, None] - points[None], axis=2)


def depth_in_skin(positions, part, skin):
    """Distances of a part's vertices to the nearest of the skin."""
    return np.sqrt(((positions[part][:, None] - positions[skin][None]) ** 2).sum(axis=2)).min(axis=1)


def assert_carried(obj, parts, positions):
    """As a rigid piece (but for a few percent of size), with the skin where it was, and turned by about 60 degrees."""
    before = baking.rest(obj)
    skin = np.setdiff1d(np.arange(len(before)), np.concatenate([part for each in parts.values() for part in each]))
    for name, each in parts.items():
        for part in each:
            grown = distances(positions[part]) / np.where(np.eye(len(part)), 1.0, distances(before[part]))
            factors = grown[~np.eye(len(part), dtype=bool)]
            assert np.ptp(factors) < 1e-3, name
            assert abs(factors.mean() - 1.0) < 0.06, name
            gap = depth_in_skin(positions, part, skin) - depth_in_skin(before, part, skin)
            assert np.abs(gap).max() < 0.06, name
    for part in parts[heads.EYES] + parts[heads.PUPILS]:
        x, y, _z = positions[part].mean(axis=0)
        was = before[part].mean(axis=0)
        turned = math.degrees(math.atan2(y, x) - math.atan2(was[1], was[0])) % 360.0
        assert abs(turned - 60.0) < 8.0


def test_eyes_go_along_with_a_turned_head_live_and_solved_and_baked(tmp_path):
    obj, control, parts = heads.head()
    turn(control)
    assert_carried(obj, parts, shown(obj))
    assert steps.summary(obj).following_part_count == 6
    live = shown(obj)
    obj.meanvalue.live = False
    steps.solve()
    assert_carried(obj, parts, shown(obj))
    assert np.abs(shown(obj) - live).max() < 0.02
    # back at rest all is at rest
    turn(control, 0.0)
    steps.solve()
    assert handles.is_at_rest(obj, 1e-4)


def test_eyes_stay_where_that_is_wanted():
    obj, control, parts = heads.head()
    turn(control)
    obj.meanvalue.loose_parts = 'stay'
    update()
    obj.meanvalue.live = False
    steps.solve()
    loose = np.concatenate([part for each in parts.values() for part in each])
    assert np.array_equal(shown(obj)[loose], rest(obj)[loose])
    assert steps.summary(obj).following_part_count == 0
    obj.meanvalue.loose_parts = 'follow'
    steps.solve()
    assert_carried(obj, parts, shown(obj))


def test_a_clip_carries_them_in_every_frame(tmp_path):
    obj, control, parts = heads.head(live=False)
    control.rotation_mode = 'XYZ'
    for frame, angle in ((1, 0.0), (8, 60.0)):
        control.rotation_euler = (0.0, 0.0, math.radians(angle))
        control.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 8
    bpy.context.scene.frame_set(1)
    steps.run(obj, "bake", path=str(tmp_path / "cache"))
    frames = baking.played(obj, [1, 8])
    assert_carried(obj, parts, frames[1])
    assert np.abs(frames[0] - baking.rest(obj)).max() < 1e-4


# -- what is messy can be seen ----------------------------------------------------------------------------------------


def selected(obj):
    bpy.ops.object.mode_set(mode='OBJECT')
    flags = np.zeros(len(obj.data.vertices), bool)
    obj.data.vertices.foreach_get("select", flags)
    return np.flatnonzero(flags).tolist()


def messy_grid():
    """A 5 x 5 grid with a doubled face of its own vertices, a loose edge and a face without area."""
    obj = meshes.grid()
    vertices = [tuple(vertex.co) for vertex in obj.data.vertices]
    faces = [tuple(polygon.vertices) for polygon in obj.data.polygons]
    vertices += [vertices[index] for index in faces[0]]  # 25 to 28: a copy of the first face
    vertices += [(9.0, 9.0, 9.0), (9.0, 9.0, 8.0)]  # 29 and 30: a loose edge
    vertices += [tuple(0.5 * (a + b) for a, b in zip(vertices[23], vertices[24], strict=True))]  # 31
    mesh = bpy.data.meshes.new("Messy")
    mesh.from_pydata(vertices, [(29, 30)], [*faces, (25, 26, 27, 28), (23, 24, 31)])
    messy = meshes.new_object("Messy", mesh)
    meshes.activate(messy)
    return messy


def test_what_is_messy_is_counted_and_selected(capfd):
    obj = messy_grid()
    obj.meanvalue.close_seams = False
    steps.list_anchors(obj, Corners=[0, 4, 20], Tip=[24])
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    for kind, vertices in (
        ('WIRE', [29, 30]),
        ('DOUBLE', [0, 1, 5, 6, 25, 26, 27, 28]),
        ('NO_AREA', [23, 24, 31]),
        ('LOOSE', [25, 26, 27, 28, 29, 30]),
    ):
        assert bpy.ops.meanvalue.select_problems(kind=kind) == {'FINISHED'}
        assert obj.mode == 'EDIT'
        assert selected(obj) == vertices
    capfd.readouterr()
    assert bpy.ops.meanvalue.select_problems() == {'FINISHED'}
    told = capfd.readouterr().out
    for text in ("Without Faces (2)", "Doubles (8)", "Faces Without Area (3)"):
        assert text in told
    assert set(selected(obj)) >= {0, 1, 5, 6, *range(23, 32)}


def test_problems_can_be_looked_for_without_a_binding():
    obj = messy_grid()
    assert bpy.ops.meanvalue.select_problems(kind='WIRE') == {'FINISHED'}
    assert selected(obj) == [29, 30]
    clean = meshes.grid()
    assert bpy.ops.meanvalue.select_problems() == {'FINISHED'}
    assert clean.mode == 'OBJECT'


def test_what_is_hidden_is_shown_when_it_is_selected():
    obj = messy_grid()
    obj.data.vertices[30].hide = True
    obj.data.edges[0].hide = True
    assert bpy.ops.meanvalue.select_problems(kind='WIRE') == {'FINISHED'}
    assert selected(obj) == [29, 30]
    assert not obj.data.vertices[30].hide
