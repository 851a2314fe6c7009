# SPDX-License-Identifier: MPL-2.0
"""A four-legged creature with horns and a tail, of any number of vertices from 6,000: one closed surface of genus 0.

Round cones over a skeleton melt into one field; surface nets make its zero surface a mesh, which is relaxed along the
surface, and bumps are pushed out of it at last. Limbs are thin beside the body, as in scanned models.
"""

import numpy as np

BLEND = 0.04  # how far from each other two bones' surfaces melt
MARGIN = 0.15  # beyond it a bone counts for nothing
TINY = 1e-30
BLOCK, BLOCKS = 8, 200  # cells of the grid along a block's side; blocks looked at together
STEEPEST = 1.05  # the field's gradient, at most
LEFT_OUT = 0.01  # what bones beyond their margins would change of the field, at most
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
    points = relaxed(np.ascontiguousarray(vertices.T), triangles, bones)
    _, slopes = field(bones, points)
    points += bumps(points) / np.linalg.norm(slopes, axis=0) * slopes
    return np.ascontiguousarray(points.T), triangles


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
    """(p,) about the distance of points (3, p) to the surface of the melted bones, negative inside; its gradients."""
    total, slopes = np.full(points.shape[1], TINY), np.zeros_like(points)
    for bone in bones:
        distance, away, inner = distance_to(bone, points)
        along = bone[3:6] - bone[:3]
        weight = weight_at(distance)
        total += weight
        for k in range(3):
            slopes[k] += weight * (away[k] - inner * (bone[7] - bone[6]) * (along[k] / (along @ along)))
    return -BLEND * np.log(total), slopes / total


def distance_to(bone, points):
    """(p,) from points (3, p) to a bone's surface; unit vectors (3, p) away from its axis; (p,) which are beside it."""
    start, along = bone[:3], bone[3:6] - bone[:3]
    x, y, z = (points[k] - start[k] for k in range(3))
    share = (x * along[0] + y * along[1] + z * along[2]) / (along @ along)
    inner = (share > 0) & (share < 1)
    share = np.clip(share, 0, 1)
    x, y, z = x - share * along[0], y - share * along[1], z - share * along[2]
    length = np.maximum(np.sqrt(squared_lengths(x, y, z)), 1e-12)
    return length - bone[6] - share * (bone[7] - bone[6]), (x / length, y / length, z / length), inner


def squared_lengths(x, y, z):
    """(p,) of vectors with these components."""
    return x * x + z * z + y * y


def weight_at(distance):
    """What a bone counts for at such distances."""
    return np.exp(np.clip(-distance / BLEND, -60, 60))


def surface_nets(bones, spacing):
    """The zero surface as (vertices (n, 3), outward triangles (m, 3))."""
    vertices, quads = nets(*crossed_edges(bones, spacing), spacing)
    return vertices, split(vertices, quads)


def nets(axes, crossings, spacing):
    """(vertices, quads): a vertex in each cell of the grid that a surface crosses, a quad for each edge of the grid.

    axes, crossings: as of crossed_edges().
    """
    sizes = [len(axis) for axis in axes]
    points, cells = [], []
    for axis, (edges, shares, _) in enumerate(crossings):
        point = np.stack([axes[k][edges[:, k]] for k in range(3)])
        point[axis] += shares * spacing
        points += 4 * [point]
        cells += [np.ravel_multi_index(around.T, sizes) for around in cells_around(edges, axis)]
    _, number = np.unique(np.concatenate(cells), return_inverse=True)  # of each cell's vertex
    sums = np.stack([np.bincount(number, row) for row in np.concatenate(points, axis=1)], axis=1)
    vertices = sums / np.bincount(number)[:, None]
    corners = np.split(number, np.cumsum([len(each) for each in cells])[:-1])
    quads = []
    for axis, (_, _, inside_first) in enumerate(crossings):
        around = np.stack(corners[4 * axis : 4 * axis + 4], axis=1)
        quads.append(np.where(inside_first[:, None], around, around[:, ::-1]))
    return vertices, np.concatenate(quads)


def crossed_edges(bones, spacing):
    """The grid's coordinates along x, y, z; and for each axis the edges along it that the surface crosses.

    These are their first points (e, 3) in the grid's order, the share of each before the surface, and whether it begins
    inside. Only blocks of the grid that the surface can reach, by the field in their middle, are sampled.
    """
    low, high = surroundings(bones)
    first = low.min(axis=0) + spacing * np.array([0.25, 0.35, 0.45])  # no symmetric points exactly on it
    axes = [np.arange(first[k], high[:, k].max() + (BLOCK + 1) * spacing, spacing) for k in range(3)]
    starts = np.meshgrid(*(range(0, len(axis) - BLOCK, BLOCK) for axis in axes), indexing="ij")
    starts = np.stack([each.ravel() for each in starts], axis=1)
    middles = np.stack([axes[k][starts[:, k]] for k in range(3)]) + 0.5 * BLOCK * spacing
    distance, _ = field(bones, middles)
    starts = starts[np.abs(distance) < STEEPEST * 0.5 * 3**0.5 * BLOCK * spacing + LEFT_OUT]
    found = [list(edges_in(starts[i : i + BLOCKS], bones, axes)) for i in range(0, len(starts), BLOCKS)]
    crossings = []
    for parts in zip(*found, strict=True):
        edges, shares, inside_first = map(np.concatenate, zip(*parts, strict=True))
        order = np.lexsort(edges.T[::-1])
        crossings.append((edges[order], shares[order], inside_first[order]))
    return axes, crossings


def surroundings(bones):
    """The boxes (b, 3), (b, 3) in which each bone counts."""
    reach = bones[:, 6:].max(axis=1, keepdims=True) + MARGIN
    return np.minimum(bones[:, :3], bones[:, 3:6]) - reach, np.maximum(bones[:, :3], bones[:, 3:6]) + reach


def edges_in(starts, bones, axes):
    """The same of the blocks with these first points (b, 3), in their order; a bone counts in its surroundings only."""
    across = np.arange(BLOCK + 1)
    x, y, z = (axes[k][starts[:, [k]] + across] for k in range(3))
    grids = np.broadcast_arrays(x[:, :, None, None], y[:, None, :, None], z[:, None, None, :])
    points = np.stack([grid.ravel() for grid in grids])
    total = np.full(points.shape[1], TINY)
    for bone, low, high in zip(bones, *surroundings(bones), strict=True):
        near = ((points >= low[:, None]) & (points < high[:, None])).all(axis=0)
        total[near] += weight_at(distance_to(bone, points[:, near])[0])
    values = (-BLEND * np.log(total)).reshape(grids[0].shape)
    before = values[:, :-1, :-1, :-1]
    for axis in range(3):
        after = np.roll(values, -1, axis + 1)[:, :-1, :-1, :-1]
        block, *steps = found = np.nonzero((before < 0) != (after < 0))
        edges = starts[block] + np.stack(steps, axis=1)
        yield edges, before[found] / (before[found] - after[found]), before[found] < 0


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


def relaxed(points, triangles, bones):
    """Points (3, p) moved along the surface to the middle of their neighbours, and back onto it."""
    pairs = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    count = np.bincount(pairs[:, 0], minlength=points.shape[1])
    for _ in range(RELAXATIONS):
        sums = np.stack([np.bincount(pairs[:, 0], each[pairs[:, 1]], len(each)) for each in points])
        points = points + 0.5 * (sums / count - points)
        height, slopes = field(bones, points)
        points -= height / np.maximum(squared_lengths(*slopes), 0.1) * slopes
    return points


def bumps(points):
    """(p,) heights: scales of two sizes."""
    x, y, z = points
    coarse = 0.012 * np.sin(14 * x + 1) * np.sin(13 * y + 2) * np.sin(15 * z)
    return coarse + 0.004 * np.sin(41 * x) * np.sin(38 * y + 1) * np.sin(43 * z + 2)
