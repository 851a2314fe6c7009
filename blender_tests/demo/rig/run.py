# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo rig`, and its report."""

import time

import bpy
import numpy as np
from mathutils import Matrix
from support import armatures, meshes, steps

from .. import pictures, pose, report, scene_mesh, stage
from . import figures

BODY_COLOUR = (0.60, 0.42, 0.33)

#: Of the length of the upper arm: how far around a joint the mesh may change, how big a handle is, how far it is moved.
REACH, GRIP, PUSH = 0.55, 0.11, 0.07

ABOUT = ("correctives on posed rigs",)
DESCRIPTION = """\
Correctives on a posed rig: an elbow and a shoulder that skinning has collapsed are pushed out where they are seen, by
the add-on's operators. Pictures of skinning alone, of the corrective, and of the arm at rest with the corrective."""
OPTIONS = {"engine": "workbench"}


def blocks(words, empty_scene):
    """The report's lines; poses, corrects, draws and measures the figure."""
    empty_scene()
    figure = figures.walker()
    obj, armature = add_body(figure)
    for bone, axis, degrees in figure.turns:
        turn(armature, bone, axis, degrees)
    skinned = meshes.seen(obj).astype(float)
    began = time.perf_counter()
    missed = correct(figure, obj, skinned)
    seconds = time.perf_counter() - began
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / "rig_walker.blend"), check_existing=False)
    path = words.output / "rig_walker.png"
    draw(path, figure, obj, armature, words)
    rows = [
        ("vertices, bones", f"{len(figure.vertices):,}, {len(figure.bones)}"),
        ("handles off controls", f"at most {missed:.1e} of the size"),
        ("seconds", f"{seconds:.2f}"),
        ("files", f"{path.name}, rig_walker.blend"),
    ]
    return [report.block("the walking figure", rows)]


def add_body(figure):
    """(mesh object, armature object) with the figure's skin."""
    obj = scene_mesh.new_object("Body", figure.vertices, figure.polygons)
    scene_mesh.shade_smooth(obj)
    obj.data.materials.append(scene_mesh.plain_material("Skin", BODY_COLOUR, 0.45))
    armature = armatures.make(**{name: bone if bone[2] else bone[:2] for name, bone in figure.bones.items()})
    armature.hide_render = True
    for bone, (indices, weights) in figure.weights.items():
        group = obj.vertex_groups.new(name=bone)
        for index, weight in zip(indices, weights, strict=True):
            group.add([int(index)], float(weight), 'REPLACE')
    obj.modifiers.new("Armature", 'ARMATURE').object = armature
    bpy.context.view_layer.objects.active = obj
    bpy.context.view_layer.update()
    return obj, armature


def turn(armature, bone, axis, degrees):
    """Turns a bone about its head, about an axis of the world."""
    posed = armature.pose.bones[bone]
    head = Matrix.Translation(posed.head)
    posed.matrix = head @ Matrix.Rotation(np.radians(degrees), 4, axis) @ head.inverted() @ posed.matrix
    bpy.context.view_layer.update()


def correct(figure, obj, skinned):
    """Pushes elbow and shoulder out by handles; returns how far they are off then, over the body's size."""
    shoulder, elbow = (np.array(joint) for joint in figure.arm)
    length = float(np.linalg.norm(elbow - shoulder))
    near = [np.linalg.norm(figure.vertices - joint, axis=1) < REACH * length for joint in (shoulder, elbow)]
    steps.add_group(obj, "Joints", np.flatnonzero(near[0] | near[1]))
    obj.meanvalue.roi_group = "Joints"
    tip, top = grip(figure, elbow, (0.0, 1.0, 0.0), length), grip(figure, shoulder, (0.0, 0.0, 1.0), length)
    parts = {
        "Elbow": (tip, PUSH * length * out_of_bend(figure, skinned, tip)),
        "Shoulder": (top, PUSH * length * np.array((0.0, 0.0, 1.0))),
    }
    for name, (members, _) in parts.items():
        steps.add_group(obj, name, members)
        bpy.context.view_layer.objects.active = obj
        pose.call(bpy.ops.meanvalue.add_handle, group=name)
        bpy.context.view_layer.update()
    for name, (_, push) in parts.items():
        control = obj.meanvalue.handles[name].control
        control.matrix_world = Matrix.Translation(push) @ control.matrix_world
        bpy.context.view_layer.update()
    size = float(np.linalg.norm(np.ptp(figure.vertices, axis=0)))
    after = meshes.seen(obj).astype(float)
    return max(np.abs(after[members] - skinned[members] - push).max() for members, push in parts.values()) / size


def grip(figure, joint, side, length):
    """The vertices at a joint on one of its sides, in the rest pose."""
    tip = np.linalg.norm(figure.vertices - (joint + 0.2 * length * np.array(side)), axis=1).argmin()
    return np.flatnonzero(np.linalg.norm(figure.vertices - figure.vertices[tip], axis=1) < GRIP * length)


def out_of_bend(figure, skinned, members):
    """The direction, as seen, in which the outside of the elbow points."""
    carried = [figure.weights[bone] for bone, _, _ in figure.turns]
    ends = [np.average(skinned[indices], axis=0, weights=weights) for indices, weights in carried]
    out = skinned[members].mean(axis=0) - 0.5 * (ends[0] + ends[1])
    return out / np.linalg.norm(out)


def draw(path, figure, obj, armature, words):
    """Skinning alone, the corrective, and the corrective with the arm at rest, side by side."""
    obj.meanvalue.live = False
    for each in bpy.data.objects:
        each.hide_render = each.type != 'MESH'
    key = obj.data.shape_keys.key_blocks[obj.meanvalue.result_key]
    shoulder, elbow = np.array(figure.arm)
    arm = np.linalg.norm(figure.vertices - elbow, axis=1) < 1.3 * np.linalg.norm(elbow - shoulder)
    rest = [posed.matrix_basis.copy() for posed in armature.pose.bones]
    picture = stage.Picture(720, 720, words.samples, words.engine)
    shots = []
    stage.set_stage(meshes.seen(obj)[arm].astype(float), picture, 25.0, 12.0, margin=0.02)
    for value, is_posed in ((0.0, True), (1.0, True), (1.0, False)):
        key.value = value
        for posed, basis in zip(armature.pose.bones, rest, strict=True):
            posed.matrix_basis = basis if is_posed else Matrix.Identity(4)
        bpy.context.view_layer.update()
        shots.append(stage.render(path))
    pictures.write_png(path, pictures.side_by_side(shots))
