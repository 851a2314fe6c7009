# SPDX-License-Identifier: GPL-3.0-or-later
"""A four-legged creature with horns and a tail, of any number of vertices from 6,000: one closed surface of genus 0.

Round cones over a skeleton melt into one field; surface nets make its zero surface a mesh, which is relaxed along the
surface, and bumps are pushed out of it at last. Limbs are thin beside the body, as in scanned models.
"""

import numpy as np

BLEND = 0.04  # how far from each other two bones' surfaces melt
MARGIN = 0.15  # beyond it a bone counts for nothing
TINY = 1e-30
RELAXATIONS = 12
GRIDS = 30
# Bones: the two ends with their radii. x is forwards, z up; those with y beside 0 are there on both sides.
BONES = (
    ((-0.55, 0.00, 0.00), 0.23, (0.00, 0.00, 0.04), 0.27),  # torso
    ((0.00, 0.00, 0.04), 0.27, (0.50, 0.00, 0.00), 0.24),
    ((0.52, 0.00, 0.08), 0.17, (0.85, 0.00, 0.48), 0.11),  # neck, head, snout
    ((0.85, 0.00, 0.50), 0.15, (1.00, 0.00, 0.50), 0.13),
    ((1.00, 0.00, 0.48), 0.11, (1.24, 0.00, 0.40), 0.07),
    ((0.84, 0.09, 0.60), 0.065, (0.76, 0.22, 0.82), 0.055),  # horns
    ((0.76, 0.22, 0.82), 0.055, (0.86, 0.30, 1.02), 0.045),
    ((0.48, 0.15, -0.05), 0.13, (0.52, 0.22, -0.42), 0.08),  # fore legs
    ((0.52, 0.22, -0.42), 0.08, (0.44, 0.23, -0.80), 0.06),
    ((0.44, 0.23, -0.80), 0.06, (0.56, 0.24, -0.84), 0.06),
    ((-0.52, 0.15, -0.02), 0.15, (-0.46, 0.24, -0.42), 0.09),  # hind legs
    ((-0.46, 0.24, -0.42), 0.09, (-0.62, 0.24, -0.80), 0.06),
    ((-0.62, 0.24, -0.80), 0.06, (-0.50, 0.25, -0.84), 0.06),
    ((-0.70, 0.00, 0.08), 0.11, (-1.00, 0.00, 0.26), 0.07),  # tail
    ((-1.00, 0.00, 0.26), 0.07, (-1.32, 0.08, 0.20), 0.06),
    ((-1.32, 0.08, 0.20), 0.06, (-1.60, -0.02, 0.42), 0.05),
)  # fmt: skip
IN_THE_MIDDLE = 0.085  # the tail leaves the middle by less than this and is there once


def creature(vertex_count):
    """About so many vertices (n, 3), and outward triangles (m, 3); the same numbers for the same count."""
    bones = both_sides()
    spacing = 0.036 * (7_000 / vertex_count) ** 0.5
    vertices, triangles = surface_nets(bones, spacing)
    spacing *= (len(vertices) / vertex_count) ** 0.5  # the count goes with its square, but for the thinnest limbs
    for _ in range(GRIDS):
        vertices, triangles = surface_nets(bones, spacing)
        if is_ball(vertices, triangles):
            break
        spacing *= 0.998  # some cell has two pieces of the surface and one vertex for both: another grid
    else:
        raise RuntimeError(f"no grid gives a manifold of about {vertex_count} vertices")
    vertices = relaxed(vertices, triangles, bones)
    _, slope = field(bones, vertices)
    return vertices + (bumps(vertices) / np.linalg.norm(slope, axis=1))[:, None] * slope, triangles


def is_ball(vertices, triangles):
    """Whether the triangles are closed and manifold, in one piece without tunnels."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]).astype(np.int64)
    keys = pairs[:, 0] * len(vertices) + pairs[:, 1]
    once = len(np.unique(keys)) == len(keys)
    return once and len(vertices) - len(keys) // 2 + len(triangles) == 2


def both_sides():
    """(b, 8): start, end, and the radii there, of every bone."""
    rows = []
    for start, start_radius, end, end_radius in BONES:
        for sign in (1, -1) if max(start[1], end[1]) > IN_THE_MIDDLE else (1,):
            side = np.array([1, sign, 1])
            rows.append([*(start * side), *(end * side), start_radius, end_radius])
    return np.array(rows)


def field(bones, points):
    """(p,) about the distance to the surface of the melted bones, negative inside; and its gradients (p, 3)."""
    total, slopes = np.full(len(points), TINY), np.zeros((len(points), 3))
    for bone in bones:
        distance, slope = distance_to(bone, points)
        weight = np.exp(np.clip(-distance / BLEND, -60, 60))
        total += weight
        slopes += weight[:, None] * slope
    return -BLEND * np.log(total), slopes / total[:, None]


def distance_to(bone, points):
    """(p,) from points (p, 3) to a bone's surface, and its gradients (p, 3)."""
    start, along, widening = bone[:3], bone[3:6] - bone[:3], bone[7] - bone[6]
    share = (points - start) @ along / (along @ along)
    inner = (share > 0) & (share < 1)
    share = np.clip(share, 0, 1)
    away = points - start - share[:, None] * along
    length = np.maximum(np.sqrt(np.einsum("ij,ij->i", away, away)), 1e-12)
    slope = away / length[:, None] - np.outer(inner * widening, along / (along @ along))
    return length - bone[6] - share * widening, slope


def surface_nets(bones, spacing):
    """The zero surface: a vertex in each cell of the grid that it crosses, a quad for each edge of the grid."""
    axes, values = sampled(bones, spacing)
    sums, counts = np.zeros((*values.shape, 3)), np.zeros(values.shape)
    crossings = [edge_crossings(values, axis) for axis in range(3)]
    for axis, (cells, shares, _) in enumerate(crossings):
        points = np.stack([axes[k][cells[:, k]] for k in range(3)], axis=1)
        points[:, axis] += shares * spacing
        for around in cells_around(cells, axis):
            np.add.at(sums, tuple(around.T), points)
            np.add.at(counts, tuple(around.T), 1)
    crossed = counts > 0
    number = np.full(values.shape, -1)  # of each cell's vertex
    number[crossed] = np.arange(crossed.sum())
    vertices = sums[crossed] / counts[crossed][:, None]
    quads = []
    for axis, (cells, _, inside_first) in enumerate(crossings):
        corners = np.stack([number[tuple(around.T)] for around in cells_around(cells, axis)], axis=1)
        quads.append(np.where(inside_first[:, None], corners, corners[:, ::-1]))
    return vertices, split(vertices, np.concatenate(quads))


def sampled(bones, spacing):
    """The grid's coordinates along x, y, z, and the field at its points; a bone counts in its surroundings only."""
    reach = bones[:, 6:].max(axis=1, keepdims=True) + MARGIN
    low = np.minimum(bones[:, :3], bones[:, 3:6]) - reach
    high = np.maximum(bones[:, :3], bones[:, 3:6]) + reach
    first = low.min(axis=0) + spacing * np.array([0.25, 0.35, 0.45])  # no symmetric points exactly on it
    axes = [np.arange(first[k], high[:, k].max(), spacing) for k in range(3)]
    total = np.full([len(axis) for axis in axes], TINY)
    for bone, bone_low, bone_high in zip(bones, low, high, strict=True):
        box = tuple(slice(*np.searchsorted(axes[k], [bone_low[k], bone_high[k]])) for k in range(3))
        points = np.stack(np.meshgrid(*(axes[k][box[k]] for k in range(3)), indexing="ij"), axis=-1)
        distance, _ = distance_to(bone, points.reshape(-1, 3))
        total[box] += np.exp(np.clip(-distance / BLEND, -60, 60)).reshape(points.shape[:3])
    return axes, -BLEND * np.log(total)


def edge_crossings(values, axis):
    """Edges of the grid along an axis that change sign: their first points (e, 3), the shares, which begin inside."""
    before = np.take(values, range(values.shape[axis] - 1), axis)
    after = np.take(values, range(1, values.shape[axis]), axis)
    cells = np.argwhere((before < 0) != (after < 0))
    at = tuple(cells.T)
    return cells, before[at] / (before[at] - after[at]), before[at] < 0


def cells_around(cells, axis):
    """The four cells (e, 3) around each of the grid's edges, counter-clockwise seen from the axis' far end."""
    one, other = np.eye(3, dtype=int)[(axis + 1) % 3], np.eye(3, dtype=int)[(axis + 2) % 3]
    return [cells - one - other, cells - other, cells, cells - one]


def split(vertices, quads):
    """Triangles (m, 3) int32 of the quads (q, 4), each along its shorter diagonal."""
    corners = vertices[quads]
    first = np.linalg.norm(corners[:, 0] - corners[:, 2], axis=1)
    second = np.linalg.norm(corners[:, 1] - corners[:, 3], axis=1)
    turned = np.where((first <= second)[:, None], quads, np.roll(quads, -1, axis=1))
    return np.stack([turned[:, [0, 1, 2]], turned[:, [0, 2, 3]]], axis=1).reshape(-1, 3).astype(np.int32)


def relaxed(vertices, triangles, bones):
    """The vertices moved along the surface to the middle of their neighbours, and back onto it."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    count = np.bincount(pairs[:, 0], minlength=len(vertices))[:, None]
    for _ in range(RELAXATIONS):
        sums = np.stack([np.bincount(pairs[:, 0], vertices[pairs[:, 1], k], len(vertices)) for k in range(3)], axis=1)
        vertices = vertices + 0.5 * (sums / count - vertices)
        height, slope = field(bones, vertices)
        vertices = vertices - (height / np.maximum(np.einsum("ij,ij->i", slope, slope), 0.1))[:, None] * slope
    return vertices


def bumps(vertices):
    """(n,) heights: scales of two sizes."""
    x, y, z = vertices.T
    coarse = 0.012 * np.sin(14 * x + 1) * np.sin(13 * y + 2) * np.sin(15 * z)
    return coarse + 0.004 * np.sin(41 * x) * np.sin(38 * y + 1) * np.sin(43 * z + 2)
