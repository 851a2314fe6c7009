# SPDX-License-Identifier: GPL-3.0-or-later
"""Film strips: frames of a moving mesh side by side in one picture, as a row of figures."""

import bpy
import numpy as np

from .. import markers, pictures, scene_mesh, stage
from .capture import BODY_COLOUR

MARKER_COLOUR, BOX_COLOUR = (0.95, 0.22, 0.02), (0.23, 0.30, 0.36)
BALL = 0.0075  # radius of a marker over the height of the figure
SIDE, FRONT = -90.0, 0.0  # azimuth of the camera from where the figure goes; seen from its right, to the right
ELEVATION_DEG = 5.0
WIDTH = 1600
FACE_TO_FACE = 0.05  # left free between two figures, over the height


def draw(path, subject, carried, samples, azimuth_deg, engine, cycles_samples, per_row=None):
    """Renders the frames `samples` as one PNG, in an empty scene; rows of `per_row`, else all in one."""
    azimuth_deg += heading_deg(subject, carried)
    right = stage.camera_axes(azimuth_deg, 0.0)[0]
    shapes, balls, boxes = in_place(subject, carried, samples)
    pitch = FACE_TO_FACE * subject.height + (
        np.ptp(np.concatenate([*shapes, *boxes]) @ right) if boxes else max(np.ptp(shape @ right) for shape in shapes)
    )
    per_row = per_row or len(samples)
    drop = 1.12 * subject.height
    for number, (shape, ball) in enumerate(zip(shapes, balls, strict=True)):
        row, column = divmod(number, per_row)
        away = column * pitch * right - np.array([0.0, 0.0, row * drop])
        shape += away
        ball += away
        if boxes:
            add_box(boxes[0] + away)
    add_figures(shapes, subject.polygons)
    everywhere = np.concatenate(balls)
    seen = everywhere[~np.isnan(everywhere[:, 0])]
    markers.add_spheres("Markers", seen, BALL * subject.height, MARKER_COLOUR)
    points = np.concatenate([*shapes, *(box + 0.0 for box in boxes)])
    render(path, points, azimuth_deg, engine, cycles_samples)


def heading_deg(subject, carried):
    """Where the figure goes: 0 along -y, as it looks where it does not go anywhere."""
    way = carried.shapes[-1].mean(axis=0) - carried.shapes[0].mean(axis=0)
    return float(np.degrees(np.arctan2(way[0], -way[1]))) if np.hypot(*way[:2]) > 0.5 * subject.height else 0.0


def in_place(subject, carried, samples):
    """(shapes, balls, boxes): each frame moved along the ground to the origin, all alike where there is a box."""
    shapes, balls = [], []
    first = carried.shapes[samples].reshape(-1, 3).astype(float)
    still = 0.5 * (first.min(0) + first.max(0)) * [1.0, 1.0, 0.0]
    for sample in samples:
        shape = carried.shapes[sample].astype(float)
        centre = still if subject.box else shape.mean(0) * [1.0, 1.0, 0.0]
        shapes.append(shape - centre)
        balls.append(carried.balls[sample] - centre)
    boxes = [np.stack(subject.box) - still] if subject.box else []
    return shapes, balls, boxes


def add_figures(shapes, polygons):
    """An object for each of the shapes (k, n, 3): copies of one, which is quicker than making each."""
    first = scene_mesh.new_object("Figure", shapes[0], polygons)
    scene_mesh.shade_smooth(first)
    first.data.materials.append(scene_mesh.plain_material("Skin", BODY_COLOUR, 0.55))
    for shape in shapes[1:]:
        obj = bpy.data.objects.new("Figure", first.data.copy())
        bpy.context.scene.collection.objects.link(obj)
        obj.data.vertices.foreach_set("co", shape.astype(np.float32).ravel())
        obj.data.update()


def add_box(ends):
    """A box from ends[0] to ends[1]."""
    corners = [(x, y, z) for z in ends[:, 2] for y in ends[:, 1] for x in ends[:, 0]]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    obj = scene_mesh.new_object("Box", corners, faces)
    obj.data.materials.append(scene_mesh.plain_material("Box", BOX_COLOUR, 0.6))


def render(path, points, azimuth_deg, engine, cycles_samples):
    """An orthographic picture of all `points` (n, 3), with a sun and a ground that takes its shadow."""
    axes = stage.camera_axes(azimuth_deg, ELEVATION_DEG)
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
    pictures.write_png(path, pictures.over_backdrop(pictures.read_png(path)))


def on_top(path, upper, lower):
    """Writes two pictures of one width, one above the other."""
    gap = np.ones((8, upper.shape[1], 4), dtype=np.float32)
    pictures.write_png(path, np.concatenate([lower, gap, upper]))
