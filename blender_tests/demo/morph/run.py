# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo morph`, and its report."""

import time

import bpy
import numpy as np
from support import meshes

from .. import built_in, pictures, pose, report, row, scene_mesh, stage
from . import subjects

APART = 0.06  # left free between two figures, over the width of the widest

ABOUT = (
    "mixing shapes",
    "Each picture has straight lines, as shape keys go, above, and the rotation-aware mix below.",
)
DESCRIPTION = """\
Shape keys that turn instead of shrinking, a sequence from one creature to another, and a part that is grafted: by the
add-on's operators on generated models. Pictures with straight lines above and the rotation-aware mix below, the .blend
files and a report."""
OPTIONS = {"subjects": subjects.MAKERS, "only": "just one of the three"}


def blocks(words, empty_scene):
    """The report's lines for each subject; makes the files."""
    return [one(make(), words, empty_scene) for name, make in subjects.MAKERS.items() if words.only in (None, name)]


def one(subject, words, empty_scene):
    """Mixes, bakes, measures and draws one subject; returns its lines of the report."""
    empty_scene()
    print(f"{subject.title}: mixing ...", flush=True)
    obj = add_object(subject, "Thing", subject.rest)
    add_object(subject, "Other", subject.other).hide_set(True)
    bpy.context.view_layer.objects.active = obj
    straight, turned, seconds, baked = mixed(subject, obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / f"{subject.stem}.blend"), check_existing=False)
    print(f"{subject.title}: rendering ...", flush=True)
    path = words.output / f"{subject.stem}.png"
    draw(path, subject, [straight, turned], words, empty_scene)
    rows = [
        ("baked", baked),
        ("seconds", ", ".join(f"{stage} {value:.2f}" for stage, value in seconds.items())),
        ("files", f"{path.name}, {subject.stem}.blend"),
    ]
    return report.block(subject.title, rows)


def add_object(subject, name, shape):
    obj = scene_mesh.new_object(name, shape, subject.polygons)
    scene_mesh.shade_smooth(obj)
    scene_mesh.set_vertex_colours(obj, subject.colours)
    materials = [
        scene_mesh.tinted_material("Skin", tuple(subjects.BODY_COLOUR), 0.45),
        scene_mesh.tinted_material("Sucker", tuple(subjects.BODY_COLOUR), 0.40),
        scene_mesh.plain_material("Eye", built_in.EYE_COLOUR, 0.20),
        scene_mesh.plain_material("Pupil", built_in.PUPIL_COLOUR, 0.10),
    ]
    scene_mesh.set_face_materials(obj, materials, subject.parts)
    return obj


def mixed(subject, obj):
    """(in straight lines, turned) shapes, (k, n, 3) each; {stage: seconds}; what Bake Mix made, in words."""
    if subject.mask is not None:
        group = obj.vertex_groups.new(name="Part")
        for index in np.flatnonzero(subject.mask):
            group.add([int(index)], float(subject.mask[index]), 'REPLACE')
    began = time.perf_counter()
    if subject.mask is None:
        pose.call(bpy.ops.meanvalue.morph, source="Other", name="Mix", value=0.0)
    else:
        pose.call(bpy.ops.meanvalue.morph, source="Other", name="Mix", value=0.0, part="Part")
    key = obj.data.shape_keys.key_blocks["Mix"]
    obj.meanvalue.mix.is_on = False
    straight = [shown(obj, key, value) for value in subject.values]
    obj.meanvalue.mix.is_on = True
    key.value = subject.values[1]
    bpy.context.view_layer.update()
    seconds = {"bind and first mix": time.perf_counter() - began}
    began = time.perf_counter()
    turned = [shown(obj, key, value) for value in subject.values]
    seconds["a mix"] = (time.perf_counter() - began) / len(turned)
    began = time.perf_counter()
    pose.call(bpy.ops.meanvalue.bake_mix)
    seconds["bake"] = time.perf_counter() - began
    made = len(obj.data.shape_keys.animation_data.drivers)
    return np.array(straight), np.array(turned), seconds, f"{made} in-between keys"


def shown(obj, key, value):
    """(n, 3): as Blender evaluates it."""
    key.value = value
    bpy.context.view_layer.update()
    return meshes.seen(obj)


def draw(path, subject, rows, words, empty_scene):
    """The rows one below the other."""
    views = []
    right = stage.camera_axes(subject.azimuth_deg, 0.0)[0]
    pitch = (1.0 + APART) * max(np.ptp(shape @ right) for shapes in rows for shape in shapes)
    for shapes in rows:
        empty_scene()
        placed = [shape + number * pitch * right for number, shape in enumerate(shapes)]
        row.add_copies(add_object(subject, "Thing", placed[0]), placed)
        points = np.concatenate(placed)
        row.render(path, points, subject.azimuth_deg, words.engine, words.samples, subject.elevation_deg)
        views.append(pictures.read_png(path))
    row.on_top(path, *views)
