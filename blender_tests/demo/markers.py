# SPDX-License-Identifier: GPL-3.0-or-later
"""Small spheres that show the anchors (orange) and the border of the region (blue)."""

import numpy as np

from . import scene_mesh

ANCHOR_COLOUR, BORDER_COLOUR = (0.95, 0.22, 0.02), (0.02, 0.16, 0.75)
ANCHOR_RADIUS, BORDER_RADIUS = 0.0085, 0.0035  # over the bounding-box diagonal
CROWD = 12  # more anchors than this get smaller spheres
MOST_ANCHORS, MOST_BORDER = 80, 400  # more spheres would hide the mesh


def sphere(subdivisions=2):
    """Unit sphere: vertices (n, 3) and triangles (m, 3), from an octahedron."""
    vertices = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
    triangles = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(subdivisions):
        corners = vertices[triangles]
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
        both = np.concatenate([corners, middles], axis=1).reshape(-1, 3).round(12)
        points, index = np.unique(both, axis=0, return_inverse=True)
        a, b, c, ab, bc, ca = index.reshape(-1, 6).T
        triangles = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
        vertices = points / np.linalg.norm(points, axis=1, keepdims=True)
    return vertices, triangles


def add_anchor_spheres(name, centres, diagonal):
    """Spheres at the anchors `centres` (k, 3), or at some of them where there are many."""
    size = max(0.4, min(1.0, (CROWD / len(centres)) ** 0.5))
    return add_spheres(name, thinned(centres, MOST_ANCHORS), size * ANCHOR_RADIUS * diagonal, ANCHOR_COLOUR)


def add_border_spheres(name, centres, diagonal):
    """Spheres along the region's border `centres` (k, 3)."""
    return add_spheres(name, thinned(centres, MOST_BORDER), BORDER_RADIUS * diagonal, BORDER_COLOUR)


def thinned(points, most):
    """At most about `most` of the points, evenly taken."""
    return points[:: -(-len(points) // most)]


def add_spheres(name, centres, radius, colour):
    """One object with a sphere at each of `centres` (k, 3)."""
    unit, triangles = sphere()
    vertices = (centres[:, None] + radius * unit[None]).reshape(-1, 3)
    faces = (triangles[None] + len(unit) * np.arange(len(centres))[:, None, None]).reshape(-1, 3)
    obj = scene_mesh.new_object(name, vertices, faces)
    scene_mesh.shade_smooth(obj)
    obj.data.materials.append(scene_mesh.plain_material(name, colour, 0.35))
    return obj


def border_vertices(obj, roi):
    """Indices of the vertices outside the region, boolean `roi` (n,), that an edge joins to it."""
    edges = scene_mesh.edges(obj)
    crossing = edges[roi[edges[:, 0]] != roi[edges[:, 1]]]
    return np.setdiff1d(crossing, np.flatnonzero(roi))
