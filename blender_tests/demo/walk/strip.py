# SPDX-License-Identifier: GPL-3.0-or-later
"""Film strips: frames of a moving mesh side by side in one picture, as a row of figures."""

import numpy as np

from .. import markers, row, scene_mesh, stage
from .capture import BODY_COLOUR

MARKER_COLOUR, BOX_COLOUR = (0.95, 0.22, 0.02), (0.23, 0.30, 0.36)
BALL = 0.0075  # radius of a marker over the height of the figure
SIDE, FRONT = -90.0, 0.0  # azimuth of the camera from where the figure goes; seen from its right, to the right
FACE_TO_FACE = 0.05  # left free between two figures, over the height


def draw(path, subject, carried, samples, azimuth_deg, engine, cycles_samples):
    """Renders the frames `samples` as one PNG, in an empty scene."""
    azimuth_deg += heading_deg(subject, carried)
    right = stage.camera_axes(azimuth_deg, 0.0)[0]
    shapes, balls, boxes = in_place(subject, carried, samples)
    pitch = FACE_TO_FACE * subject.height + (
        np.ptp(np.concatenate([*shapes, *boxes]) @ right) if boxes else max(np.ptp(shape @ right) for shape in shapes)
    )
    for number, (shape, ball) in enumerate(zip(shapes, balls, strict=True)):
        away = number * pitch * right
        shape += away
        ball += away
        if boxes:
            add_box(boxes[0] + away)
    add_figures(shapes, subject.polygons)
    everywhere = np.concatenate(balls)
    seen = everywhere[~np.isnan(everywhere[:, 0])]
    markers.add_spheres("Markers", seen, BALL * subject.height, MARKER_COLOUR)
    points = np.concatenate([*shapes, *(box + 0.0 for box in boxes)])
    row.render(path, points, azimuth_deg, engine, cycles_samples)


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
    """An object for each of the shapes (k, n, 3)."""
    first = scene_mesh.new_object("Figure", shapes[0], polygons)
    scene_mesh.shade_smooth(first)
    first.data.materials.append(scene_mesh.plain_material("Skin", BODY_COLOUR, 0.55))
    row.add_copies(first, shapes)


def add_box(ends):
    """A box from ends[0] to ends[1]."""
    corners = [(x, y, z) for z in ends[:, 2] for y in ends[:, 1] for x in ends[:, 0]]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    obj = scene_mesh.new_object("Box", corners, faces)
    obj.data.materials.append(scene_mesh.plain_material("Box", BOX_COLOUR, 0.6))
