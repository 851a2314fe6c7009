# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures in a row in one orthographic picture."""

import bpy
import numpy as np

from . import pictures, stage

ELEVATION_DEG = 5.0
WIDTH = 1600


def add_copies(first, shapes):
    """Objects like `first`, which has the first of the shapes (k, n, 3), for the others. Quicker than making each."""
    for shape in shapes[1:]:
        obj = bpy.data.objects.new(first.name, first.data.copy())
        bpy.context.scene.collection.objects.link(obj)
        obj.data.vertices.foreach_set("co", shape.astype(np.float32).ravel())
        obj.data.update()


def render(path, points, azimuth_deg, engine, cycles_samples, elevation_deg=ELEVATION_DEG):
    """A picture of all `points` (n, 3), with a sun and a ground that takes its shadow."""
    axes = stage.camera_axes(azimuth_deg, elevation_deg)
    local = points @ axes.T
    low, high = local.min(0), local.max(0)
    margin = 0.05 * (high[1] - low[1])
    size = high[:2] - low[:2] + 2.0 * margin
    picture = stage.Picture(WIDTH, round(WIDTH * size[1] / size[0]), cycles_samples, engine)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.sensor_fit, camera.ortho_scale = "ORTHO", "HORIZONTAL", size[0]
    depth = high[2] - low[2]
    middle = np.array([*(0.5 * (low + high))[:2], high[2] + depth + 1.0])
    camera.clip_end = 4.0 * depth + 10.0
    bpy.context.scene.camera = stage.add_placed("Camera", camera, middle @ axes, axes)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3.2, 0.25
    backwards = np.array([-0.45, 1.1, 0.75]) @ axes
    backwards /= np.linalg.norm(backwards)
    across = np.cross([0.0, 0.0, 1.0], backwards)
    across /= np.linalg.norm(across)
    stage.add_placed("Sun", sun, np.zeros(3), np.stack([across, np.cross(backwards, across), backwards]))
    stage.set_world()
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.45
    if engine == "CYCLES":
        stage.add_ground(0.5 * (points.min(0) + points.max(0)), float(points[:, 2].min()), 40.0)
    stage.set_render(picture)
    stage.render(path)


def on_top(path, upper, lower):
    """Writes two pictures of one width, one above the other."""
    gap = np.ones((8, upper.shape[1], 4), dtype=np.float32)
    pictures.write_png(path, np.concatenate([lower, gap, upper]))
