# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo bones`, and its report."""

import bpy
import numpy as np

from . import pose, report, row, scene_mesh, stage
from .walk import capture, strip, subjects

ABOUT = ("a clip as bones and weights",)
DESCRIPTION = """\
The walk of ./dev demo walk is baked to an armature. A picture of both, what moves by the capture above what moves by
bones, with the skeleton drawn in front, and a report of how near it is."""
OPTIONS = {"engine": "workbench"}

BONE_COLOUR = (0.95, 0.55, 0.05)
FIGURES = 5
THICKNESS = 0.1  # of a bone, over its length


def blocks(words, empty_scene):
    """The report's lines; makes the picture."""
    empty_scene()
    subject = subjects.walk(words.output)
    carried = capture.carry(subject, words.output)
    obj = bpy.data.objects[subject.stem]
    pose.call(bpy.ops.meanvalue.bake, target="ARMATURE", frame_range="SCENE", confirm=True)
    shapes, bones = played(obj)
    off = np.linalg.norm(shapes - carried.shapes, axis=2) / np.linalg.norm(np.ptp(subject.vertices, axis=0))
    made, path = obj.meanvalue.baked.note, words.output / "bones.png"
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / "bones.blend"), check_existing=False)
    empty_scene()
    samples = subject.shown[np.linspace(0, len(subject.shown) - 2, FIGURES).astype(int)]
    draw(path, subject, carried, shapes, bones, samples, words)
    near = f"rms {np.sqrt(np.mean(off**2)):.2%} of the size, largest {off.max():.2%}, frame {off.max(1).argmax() + 1}"
    return [report.block("walk", [("made", made), ("off", near), ("files", f"{path.name}, bones.blend")])]


def played(obj):
    """(shapes (f, n, 3), bones (f, b, 2, 3) from head to tail) in the world."""
    scene, rig, shapes, bones = bpy.context.scene, obj.meanvalue.baked.rig, [], []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        shapes.append(pose.seen_in_world(obj))
        bones.append([[rig.matrix_world @ end for end in (bone.head, bone.tail)] for bone in rig.pose.bones])
    return np.array(shapes), np.array(bones)


def draw(path, subject, carried, shapes, bones, samples, words):
    """Renders the frames `samples` as one PNG, in an empty scene."""
    azimuth = strip.heading_deg(subject, carried) + strip.SIDE + 30.0
    right, _up, backwards = stage.camera_axes(azimuth, 0.0)
    pitch = 1.05 * max(np.ptp(shapes[each] @ right) for each in samples)
    figures, ends = [], []
    for column, sample in enumerate(samples):
        away = column * pitch * right - shapes[sample].mean(axis=0) * [1.0, 1.0, 0.0]
        figures += [carried.shapes[sample] + away + [0.0, 0.0, 1.1 * subject.height], shapes[sample] + away]
        ends += [*(bones[sample] + away + 2.0 * backwards)]
    strip.add_figures(figures, subject.polygons)
    points, faces = octahedra(np.array(ends), backwards)
    scene_mesh.new_object("Bones", points, faces).data.materials.append(scene_mesh.plain_material("Bone", BONE_COLOUR))
    row.render(path, np.concatenate([*figures, points]), azimuth, words.engine, words.samples, elevation_deg=0.0)


def octahedra(ends, across):
    """(vertices, faces) of bones (b, 2, 3) as Blender draws them; across: a direction that none points in."""
    along = ends[:, 1] - ends[:, 0]
    first = np.cross(along, across)
    second = np.cross(along, first) / np.linalg.norm(along, axis=1, keepdims=True)
    waist = (ends[:, 0] + THICKNESS * along)[:, None] + THICKNESS * np.stack([first, second, -first, -second], axis=1)
    sides = [(k, (k + 1) % 4) for k in range(4)]
    faces = np.array([*((4, j, i) for i, j in sides), *((5, i, j) for i, j in sides)])
    points = np.concatenate([waist, ends], axis=1)
    return points.reshape(-1, 3), (faces + 6 * np.arange(len(ends))[:, None, None]).reshape(-1, 3)
