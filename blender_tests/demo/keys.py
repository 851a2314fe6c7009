# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo keys`, and its report."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix
from support import faces, marked_face, meshes, steps

from . import pictures, pose, report, scene_mesh, stage
from .face.run import SKIN, colours
from .rig import figures
from .rig import run as rig

#: Values of keys in each picture of the faces; how much larger the other head is in X, Y, Z; directions of its picks.
LOOKS = {}, {"jawOpen": 1.0}, {"mouthSmile_L": 1.0, "mouthSmile_R": 1.0, "browUp_L": 1.0}, {"cheekPuff_R": 1.0}
GROWN, EYES = (1.3, 1.05, 0.9), ((0.4, -0.95, 0.2), (-0.4, -0.95, 0.2))
PICKS = (0, -1, -0.08), *EYES, (0, -1, -0.42), (0, -0.6, -0.8), *np.eye(3), *-np.eye(3)
#: (name of the kept pose, degrees of the upper arm from the T-pose, where the shoulder goes, in upper arms)
POSES = (("Arm down.L", 65.0, (0.08, 0.0, 0.04)), ("Arm up.L", -60.0, (-0.02, 0.0, 0.07)))
ABOUT = ("shape keys of another face, and correctives that stay right",)
DESCRIPTION = """\
A generated face's keys are carried onto another head. A shoulder has correctives for two poses, which drive them; then
weights change, and both are refreshed. By the add-on's operators. Two pictures, the .blend files and a report."""
OPTIONS = {}


def blocks(words, empty_scene):
    """The report's lines of both; makes the files."""
    picture = stage.Picture(420, 420, words.samples, words.engine)
    return [make(words.output, picture, empty_scene()) for make in (carried, refreshed)]


def saved(folder, name, shots):
    """A row of the report, of the files of a picture, lower row first, and of the scene."""
    pictures.write_png(folder / f"{name}.png", np.concatenate([pictures.side_by_side(row) for row in shots]))
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), check_existing=False)
    return "files", f"{name}.png, {name}.blend"


def carried(folder, picture, _scene):
    """A face's keys on another head of triangles, wider and lower."""
    ball = bmesh.new()
    bmesh.ops.create_icosphere(ball, subdivisions=5, radius=1.0)
    source, there = marked_face.make(), faces.rest()[0]
    polygons = [[vertex.index for vertex in face.verts] for face in ball.faces]
    points = np.array([source.ray_cast((0.0, 0.0, 0.0), vertex.co)[1] for vertex in ball.verts])
    target = scene_mesh.new_object("Other", points * GROWN, polygons)
    for obj, alike in ((target, points), (source, there)):
        scene_mesh.shade_smooth(obj)
        scene_mesh.set_vertex_colours(obj, colours(alike))
        obj.data.materials.append(scene_mesh.tinted_material("Skin", tuple(SKIN), 0.45))
    meshes.activate(target)
    target.meanvalue.wrap.target = source
    for way in PICKS:
        vertex, same = ((each @ way / np.linalg.norm(each, axis=1)).argmax() for each in (points, there))
        pose.call(bpy.ops.meanvalue.pick_wrap_pairs, vertex=int(vertex), place=there[same])
    pose.call(bpy.ops.meanvalue.wrap)
    pose.call(bpy.ops.meanvalue.wrap, carry=True)
    count = len({*faces.KEYS} & {*target.data.shape_keys.key_blocks.keys()})
    shots, rows = [], [("vertices", f"{len(there):,} and {len(points):,}"), ("keys", f"{count} of {len(faces.KEYS)}")]
    stage.set_stage(np.concatenate([there, points * GROWN]), picture, 14.0, 4.0, margin=0.04)
    for obj, other in ((target, source), (source, target)):
        obj.hide_render, other.hide_render, keys = False, True, obj.data.shape_keys.key_blocks
        shots.append([])
        for look in LOOKS:
            keys.foreach_set("value", [look.get(each.name, 0.0) for each in keys])
            shots[-1].append(stage.render(folder / "keys_face.png"))
    return report.block("a face's keys on another face", [*rows, saved(folder, "keys_face", shots)])


def refreshed(folder, picture, _scene):
    """A shoulder: skinning alone, as kept, after other weights, and refreshed."""
    figure, shots, seen = figures.walker(), [[], []], []
    (obj, armature), arm = rig.add_body(figure), np.array(figure.arm)
    length, away = np.linalg.norm(arm[1] - arm[0]), np.linalg.norm(figure.vertices - arm[0], axis=1)
    stage.set_stage(figure.vertices[away < 0.9 * length], picture, 20.0, 10.0, margin=0.02)

    def at(degrees):
        armature.pose.bones["upper_arm.L"].matrix_basis = Matrix()
        bpy.context.view_layer.update()
        rig.turn(armature, "upper_arm.L", (0.0, 1.0, 0.0), degrees)

    def look():
        for row, (_name, degrees, _push) in zip(shots, POSES, strict=True):
            at(degrees)
            row.append(stage.render(folder / "keys_shoulder.png"))
            seen.append(meshes.seen(obj).astype(float))

    look()
    steps.add_group(obj, "Shoulder", rig.grip(figure, arm[0], (0.0, 0.0, 1.0), length))
    pose.call(bpy.ops.meanvalue.add_handle, group="Shoulder", size=0.1)
    for name, degrees, push in POSES:
        at(degrees)
        control = obj.meanvalue.handles["Shoulder"].control
        control.matrix_world = Matrix.Translation(length * np.array(push)) @ control.matrix_world
        bpy.context.view_layer.update()
        meshes.activate(obj)
        pose.call(bpy.ops.meanvalue.keep_pose, name=name)
        pose.call(bpy.ops.meanvalue.drive_by_bone)
    control.hide_render, obj.meanvalue.live = True, False
    look()
    bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
    bpy.ops.object.vertex_group_smooth(group_select_mode='ALL', factor=1.0, repeat=60)
    bpy.ops.object.mode_set(mode='OBJECT')
    look()
    pose.call(bpy.ops.meanvalue.drive_by_bone, does='REFRESH_ALL')
    look()
    off = [np.abs(np.subtract(seen[k : k + 2], seen[2:4])).max() / np.ptp(figure.vertices) for k in (4, 6)]
    rows = [("vertices", f"{len(away):,}"), ("off the kept shapes", f"{off[0]:.2%} of the height, then {off[1]:.1e}")]
    return report.block("correctives that stay right", [*rows, saved(folder, "keys_shoulder", shots)])
