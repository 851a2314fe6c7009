# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies that are symmetric about three planes, whole and cut down to one part; triangles only."""

import numpy as np


def body(cells=8, bumps=0.15):
    """A closed surface around the origin: vertices n x 3, triangles m x 3. `cells` must be even: then some lie in the
    planes. Every octant is triangulated as the mirror image of the others."""
    numbers, points, triangles = {}, [], []

    def vertex(place):
        if place not in numbers:
            numbers[place] = len(points)
            points.append(place)
        return numbers[place]

    for axis in range(3):
        for side in (0, cells):
            for a in range(cells):
                for b in range(cells):
                    corners = []
                    for i, j in ((a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)):
                        place = [i, j]
                        place.insert(axis, side)
                        corners.append(vertex(tuple(place)))
                    if (side == 0) != (axis == 1):
                        corners.reverse()
                    is_mirrored = (a < cells // 2) != (b < cells // 2)
                    first = next(
                        n for n, each in enumerate(corners) if _corner(points[each], axis, a, b) == is_mirrored
                    )
                    p, q, r, s = corners[first:] + corners[:first]
                    triangles += [(p, q, r), (p, r, s)]
    grid = np.array(points, float) / cells * 2.0 - 1.0
    sphere = grid / np.linalg.norm(grid, axis=1)[:, None]
    swell = 1.0 + bumps * np.cos(3.0 * np.abs(sphere[:, 0])) * np.sin(4.0 * np.abs(sphere[:, 2]) + 1.0)
    return sphere * swell[:, None] * [1.0, 0.8, 2.0], np.array(triangles, np.int32)


def _corner(place, axis, a, b):
    """Whether a cell's diagonal may begin at this corner: (a, b) or the one across, or else the two others."""
    i, j = [each for number, each in enumerate(place) if number != axis]
    return (i == a) != (j == b)


def part(vertices, triangles, axes):
    """(numbers, triangles): what is left of the side above zero of each axis, numbered anew; `numbers` in the whole."""
    keep = np.all([vertices[:, axis] > -1e-9 for axis in axes], axis=0)
    inside = triangles[keep[triangles].all(axis=1)]
    numbers = np.flatnonzero(keep)
    new = np.full(len(vertices), -1, np.int32)
    new[numbers] = np.arange(len(numbers))
    return numbers, new[inside]
