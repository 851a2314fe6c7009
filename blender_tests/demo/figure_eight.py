# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure-eight: a closed quad mesh of genus 2, for the twist of the paper's Figure 3. No bpy."""

from dataclasses import dataclass, replace

import numpy as np

from .quad_mesh import QuadCage, QuadMesh, subdivide

# The cage is the border of a 5 x 3 plate of cells, one cell thick, without the two cells of the holes.
CELLS = np.array([[1, 1, 1, 1, 1], [1, 0, 1, 0, 1], [1, 1, 1, 1, 1]], dtype=bool)
# Where the plate's lattice lines go: x by lattice column, y by lattice row, seen along z while it lies.
LATTICE_X = np.array([-2.30, -1.45, -0.45, 0.45, 1.45, 2.30])
LATTICE_Y = np.array([-1.15, -0.48, 0.48, 1.15])
HALF_THICKNESS = 0.30
SUBDIVISIONS = 3

# The surface the cage is drawn onto: two rings side by side, blended where they touch.
RING_CENTRE_X, RING_RADIUS, TUBE_RADIUS = 0.98, 1.0, 0.34
BLEND_LENGTH = 0.35
PROJECTION_STEPS, DIFFERENCE_STEP = 5, 1e-4
RELAXATION_SWEEPS = 4


@dataclass(frozen=True)
class FigureEight:
    """The mesh, an 8 that stands along z and faces -y, and the indices of four anchor vertices at each end."""

    mesh: QuadMesh
    lower_anchors: np.ndarray
    upper_anchors: np.ndarray


def build_figure_eight():
    """The figure-eight, 3,198 vertices and about 4.6 units tall."""
    mesh = plate_cage().mesh()
    for _ in range(SUBDIVISIONS):
        mesh = subdivide(mesh)
        vertices = mesh.vertices
        for _ in range(RELAXATION_SWEEPS):
            vertices = onto_surface(neighbour_mean(mesh.quads, vertices))
        mesh = replace(mesh, vertices=vertices)
    lower, upper = end_anchors(mesh, -1.0), end_anchors(mesh, 1.0)
    standing = mesh.vertices[:, [1, 2, 0]]  # a cyclic exchange of axes is a rotation: outside stays outside
    return FigureEight(replace(mesh, vertices=standing), lower, upper)


def surface_distance(points):
    """About the signed distance (n,) of `points` (n, 3) to the two blended rings; negative inside."""
    x, y, z = points.T
    left, right = (
        np.hypot(np.hypot(x - side * RING_CENTRE_X, y) - RING_RADIUS, z) - TUBE_RADIUS for side in (-1.0, 1.0)
    )
    overlap = np.maximum(BLEND_LENGTH - np.abs(left - right), 0.0) / BLEND_LENGTH
    return np.minimum(left, right) - 0.25 * BLEND_LENGTH * overlap**2


def onto_surface(points):
    """`points` (n, 3) moved along the distance's gradient onto the surface, by Newton's method."""
    for _ in range(PROJECTION_STEPS):
        gradient = np.empty_like(points)
        for axis in range(3):
            step = DIFFERENCE_STEP * np.eye(3)[axis]
            gradient[:, axis] = surface_distance(points + step) - surface_distance(points - step)
        gradient /= 2.0 * DIFFERENCE_STEP
        squared = np.maximum(np.sum(gradient**2, axis=1), 0.1)  # the gradient fades where the rings blend
        points = points - (surface_distance(points) / squared)[:, None] * gradient
    return points


def neighbour_mean(quads, vertices):
    """Each vertex at the mean of its edge neighbours: evens out the quads before a projection."""
    mean, count = np.zeros_like(vertices), np.zeros(len(vertices))
    for k in range(4):
        np.add.at(mean, quads[:, k], vertices[quads[:, (k + 1) % 4]])
        np.add.at(count, quads[:, k], 1.0)  # each edge is met once from either end
    return mean / count[:, None]


def plate_cage():
    """The border quads of the plate's cells."""
    cage, vertex_of = QuadCage(), {}

    def vertex(column, row, side):
        key = (column, row, side)
        if key not in vertex_of:
            position = [LATTICE_X[column], LATTICE_Y[row], (2 * side - 1) * HALF_THICKNESS]
            (vertex_of[key],) = cage.add_vertices([position])
        return vertex_of[key]

    solid = np.pad(CELLS, 1)
    for row, column in np.argwhere(CELLS):
        x0, x1, y0, y1 = column, column + 1, row, row + 1
        cage.add_quad([vertex(x0, y0, 1), vertex(x1, y0, 1), vertex(x1, y1, 1), vertex(x0, y1, 1)])
        cage.add_quad([vertex(x0, y0, 0), vertex(x0, y1, 0), vertex(x1, y1, 0), vertex(x1, y0, 0)])
        walls = {
            (-1, 0): [(x0, y0), (x1, y0)],
            (0, 1): [(x1, y0), (x1, y1)],
            (1, 0): [(x1, y1), (x0, y1)],
            (0, -1): [(x0, y1), (x0, y0)],
        }
        for (row_step, column_step), (start, end) in walls.items():
            if not solid[row + 1 + row_step, column + 1 + column_step]:
                cage.add_quad([vertex(*start, 0), vertex(*end, 0), vertex(*end, 1), vertex(*start, 1)])
    return cage


def end_anchors(mesh, side):
    """Four vertices at one end (side -1 or 1): the corners of a rectangle across the tube's outer half."""
    x_tip = RING_CENTRE_X + RING_RADIUS + 0.5 * TUBE_RADIUS
    corners = [[side * x_tip, y, z] for y in (-0.45, 0.45) for z in (-TUBE_RADIUS, TUBE_RADIUS)]
    distance = np.linalg.norm(mesh.vertices[None] - np.array(corners)[:, None], axis=2)
    return np.argmin(distance, axis=1)
