# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo example`, and its report."""

import time

import bpy
import numpy as np
from support import meshes, steps

from .. import pictures, pose, report, stage
from ..rig import figures
from ..rig.run import add_body
from . import limbs

ABOUT = (
    "figures posed like their own rigs",
    "Handles at hands, feet, elbows and knees go to where skinning has them. Errors are root mean squares beside that,",
    "over the figure's height, of poses that are not among the examples.",
)
DESCRIPTION = """\
Pose Like: Own Rig. A figure is posed by handles at hands, feet, elbows and knees, by the add-on's operators, without
examples and with ten poses of its rig. Pictures of skinning, of the pose without and with examples, and a report."""
OPTIONS = {"engine": "workbench"}


def blocks(words, empty_scene):
    """The report's lines; poses, draws and measures the figure."""
    empty_scene()
    figure = figures.walker()
    obj, truths, shapes, seconds = carry(figure)
    count = sum(key.name.startswith("Rig Pose") for key in obj.data.shape_keys.key_blocks)
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / "example_walker.blend"), check_existing=False)
    path = words.output / "example_walker.png"
    shown = [truths[0], shapes["NOTHING"][0], shapes["RIG"][0]]
    draw_shapes(path, obj, shown, stage.Picture(560, 900, words.samples, words.engine), np.concatenate(shown))
    rows = [("vertices, examples", f"{len(figure.vertices):,}, {count}")]
    for name, (without, with_them) in errors(figure, truths, shapes).items():
        rows.append((name, f"{without:.2%} without, {with_them:.2%} with: {with_them / without:.2f} of it"))
    rows.append(("seconds", ", ".join(f"{stage} {value:.1f}" for stage, value in seconds.items())))
    rows.append(("files", f"{path.name}, example_walker.blend"))
    return [report.block("the walking figure", rows)]


def carry(figure):
    """Poses a figure without and with examples: (object, truths, {pose_like: shapes}, {stage: seconds}).

    truths, shapes: (n, 3) for each of limbs.ASKED
    """
    obj, armature = add_body(figure)
    truths = skinned(obj, armature)
    limbs.animate(armature)
    began = time.perf_counter()
    bpy.context.view_layer.objects.active = obj
    pose.call(bpy.ops.meanvalue.sample_rig_poses, count=len(limbs.ANIMATED))
    seconds = {"sampling": time.perf_counter() - began}
    limbs.rest(armature)
    hold(obj, limbs.holds(figure), truths)
    shapes = {}
    for like, stage_name in (("NOTHING", "posing"), ("RIG", "with examples")):
        obj.meanvalue.pose_like = like
        began = time.perf_counter()
        pose.call(bpy.ops.meanvalue.bind)
        shapes[like] = [posed(obj, number) for number in range(len(truths))]
        seconds[stage_name] = time.perf_counter() - began
    return obj, truths, shapes, seconds


def skinned(obj, armature):
    """[(n, 3)]: where the rig has the mesh in the poses that are asked for."""
    found = []
    for number in range(len(limbs.ASKED)):
        limbs.bend(armature, limbs.ASKED, number)
        found.append(meshes.seen(obj).astype(float))
    return found


def hold(obj, holds, truths):
    """Adds what holds the mesh, {name: vertices}, and muted keys with the poses that are asked for."""
    for name, members in holds.items():
        steps.add_group(obj, name, members)
        bpy.context.view_layer.objects.active = obj
        pose.call(bpy.ops.meanvalue.add_handle, group=name, pin=True)
    for number, truth in enumerate(truths):
        steps.add_key(obj, f"Asked {number}", truth).mute = True


def posed(obj, number):
    """(n, 3): the mesh after its handles were put to where a key has them."""
    pose.call(bpy.ops.meanvalue.solve_from_key, key=f"Asked {number}")
    return pose.positions(obj, obj.data.shape_keys.key_blocks[obj.meanvalue.result_key])


def errors(figure, truths, shapes):
    """{where: (without, with examples)}: of the whole and around joints, over the figure's height."""
    height = np.ptp(figure.vertices[:, 2])
    parts = {"off skinning": slice(None), **limbs.joints(figure)}
    return {
        name: tuple(
            np.mean([rms(shape[members], truth[members]) for shape, truth in zip(shapes[like], truths, strict=True)])
            / height
            for like in ("NOTHING", "RIG")
        )
        for name, members in parts.items()
    }


def rms(shape, truth):
    return float(np.sqrt(((shape - truth) ** 2).sum(axis=1).mean()))


def draw_shapes(path, obj, shapes, picture, points, azimuth=25.0):
    """Shapes of the result key side by side; points: (p, 3) that the picture shows, from `azimuth` degrees."""
    for each in bpy.data.objects:
        each.hide_render = each != obj
    key = obj.data.shape_keys.key_blocks[obj.meanvalue.result_key]
    key.value = 1.0
    stage.set_stage(points, picture, azimuth, 8.0, margin=0.02)
    drawn = []
    for shape in shapes:
        key.data.foreach_set("co", shape.astype(np.float32).ravel())
        obj.data.update_tag()
        bpy.context.view_layer.update()
        drawn.append(stage.render(path))
    pictures.write_png(path, pictures.side_by_side(drawn))
