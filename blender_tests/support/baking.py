# SPDX-License-Identifier: GPL-3.0-or-later
"""An animated tube to bake, and what Blender shows of it at every frame."""

import bpy
import numpy as np

from . import handles, installed, meshes, steps

FRAMES = 12


def animated_tube(name="Tube", frames=FRAMES, live=False):
    """(object, control): the tube of support.handles, its control keyed from frame 1 on a way that is not straight."""
    obj, control = handles.tube(name, live=live)
    key_control(control, frames)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, frames
    bpy.context.scene.frame_set(1)
    meshes.activate(obj)
    return obj, control


def key_control(control, frames=FRAMES, reach=1.5):
    base = tuple(control.location)
    for frame in (*range(1, frames, 3), frames):
        phase = 0.5 * (frame - 1)
        control.location = [base[0] + reach * np.sin(phase), base[1] + 0.2 * phase, base[2]]
        control.rotation_euler = (0.1 * phase, 0.0, 0.0)
        control.keyframe_insert("location", frame=frame)
        control.keyframe_insert("rotation_euler", frame=frame)


def curves(id_block):
    """Its F-curves, wherever this Blender keeps them."""
    return list(installed.part("compat").curves_to_read(id_block))


def rest(obj):
    """n x 3 float32, whether there are shape keys or not."""
    positions = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", positions)
    return positions.reshape(-1, 3)


def played(obj, times):
    """(f, n, 3) float32: shown() at each time."""
    shapes = []
    for time in times:
        steps.go_to(time)
        shapes.append(meshes.seen(obj))
    return np.stack(shapes)


def bake(**options):
    assert bpy.ops.meanvalue.bake(**options) == {'FINISHED'}


def save(tmp_path, name="scene.blend"):
    path = tmp_path / name
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def saved_tube(tmp_path):
    """(object, control, path of its cache) of animated_tube() in a saved file."""
    obj, control = animated_tube()
    save(tmp_path)
    return obj, control, tmp_path / "meanvalue_cache" / "scene" / f"{obj.name}.pc2"


def rows(path):
    """(f, n, 3) float32 of a point cache."""
    return np.array(installed.part("baking.core.point_cache").mapped(path))
