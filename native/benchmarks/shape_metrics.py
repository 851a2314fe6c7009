# SPDX-License-Identifier: MPL-2.0
"""How good a deformed triangle mesh is, in numbers. Shapes are (n, 3), faces (m, 3)."""

import numpy as np

from addon.scene.core.motion import nearest_rotations


def farthest_points(edges, vertices, count):
    """Numbers of `count` vertices, each as far along the edges as can be from those before; deterministic.

    edges: table1_cases.Edges. The first is the one farthest from the middle of the bounding box, and in a mesh of
    several parts every part gets its first one (its distance is infinite) before any gets a second.
    """
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    chosen = [int(np.linalg.norm(vertices - middle, axis=1).argmax())]
    distance = edges.distances(chosen)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, edges.distances(chosen[-1:]))
    return np.array(chosen)


def vertex_errors(shape, truth, diagonal):
    """(rms, largest) distance of the vertices over the diagonal."""
    distance = np.linalg.norm(shape - truth, axis=1) / diagonal
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())


def edge_error(shape, truth, faces):
    """Rms of (length / true length - 1) over the edges, each counted once."""
    pairs = unique_edges(faces)
    lengths = [np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1) for points in (shape, truth)]
    return float(np.sqrt(np.mean((lengths[0] / lengths[1] - 1) ** 2)))


def dihedral_error(shape, truth, faces):
    """Rms difference of the angles across inner edges, in degrees."""
    sides = inner_edges(faces)
    difference = dihedrals(shape, faces, sides) - dihedrals(truth, faces, sides)
    difference = (difference + np.pi) % (2 * np.pi) - np.pi
    return float(np.degrees(np.sqrt(np.mean(difference**2))))


def unique_edges(faces):
    """(e, 2) vertex numbers, lower first."""
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def inner_edges(faces):
    """(e, 4): the start and end of each edge with two triangles, the triangle that runs along it, and the other."""
    pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    owner = np.tile(np.arange(len(faces)), 3)
    count = pairs.max() + 1
    key, reverse = pairs[:, 0] * count + pairs[:, 1], pairs[:, 1] * count + pairs[:, 0]
    order = np.argsort(key)
    place = np.minimum(np.searchsorted(key[order], reverse), len(key) - 1)
    partner = order[place]
    has_partner = (key[partner] == reverse) & (pairs[:, 0] < pairs[:, 1])
    return np.column_stack([pairs, owner, owner[partner]])[has_partner]


def dihedrals(shape, faces, sides):
    """(e,) signed angles between the normals across inner edges, in radians; 0 is flat, positive convex."""
    normals = unit_normals(shape, faces)
    along = shape[sides[:, 1]] - shape[sides[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    first, second = normals[sides[:, 2]], normals[sides[:, 3]]
    sine = np.einsum("ij,ij->i", np.cross(first, second), along)
    return np.arctan2(sine, np.einsum("ij,ij->i", first, second))


def unit_normals(shape, faces):
    """(m, 3); zero for a triangle without area."""
    corners = shape[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)


def flipped_triangles(shape, rest, faces):
    """How many triangles are flipped: flipped_mask()."""
    return int(np.count_nonzero(flipped_mask(shape, rest, faces)))


def flipped_mask(shape, rest, triangles):
    """(m,) bool: triangles that point against what their surroundings make of their rest normal.

    For each vertex the rotation is found that carries the edges of its triangles from rest to shape at best; the sum of
    those of a triangle's corners, made a rotation again, carries its rest normal. Flipped is whose normal is more than
    90 degrees off that. A fold of one triangle counts; a part that turned as a whole does not, and what is folded at
    rest may stay so.

    rest, shape: (n, 3); triangles: (m, 3) vertex numbers.
    """
    edges = unique_edges(triangles)
    moved, still = (each[edges[:, 1]] - each[edges[:, 0]] for each in (shape, rest))
    products = np.einsum("ei,ej->eij", moved, still)
    moments = np.zeros((len(rest), 3, 3))
    for end in (0, 1):
        np.add.at(moments, edges[:, end], products)
    turns = nearest_rotations(nearest_rotations(moments)[triangles].sum(axis=1))
    expected = np.einsum("mij,mj->mi", turns, unit_normals(rest, triangles))
    return np.einsum("mj,mj->m", expected, unit_normals(shape, triangles)) < 0.0


def volume(shape, faces):
    """Signed; holes are closed by fans to the mean of their border, so that open meshes have one too."""
    corners = shape[faces]
    total = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    for loop in border_loops(faces):
        centre = shape[loop].mean(axis=0)
        following = np.roll(loop, -1)
        total += np.sum(centre * np.cross(shape[following], shape[loop]))
    return float(total / 6)


def border_loops(faces):
    """Vertex numbers along each border, in the direction of its triangles."""
    pairs = {(int(a), int(b)) for a, b in np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])}
    following = {a: b for a, b in sorted(pairs) if (b, a) not in pairs}
    loops = []
    while following:
        loop = [next(iter(following))]
        while loop[-1] in following:
            loop.append(following.pop(loop[-1]))
        loops.append(np.array(loop[:-1]))
    return loops


def section_turns(shape, rest, axis, sections):
    """(heights (k,), turns (k,)): by how many degrees each cross-section turned about a coordinate axis.

    sections: (k,) arrays of vertex numbers, in the order of height; a turn is followed beyond 180 degrees.
    """
    first, second = (axis + 1) % 3, (axis + 2) % 3
    heights, turns = [], []
    for members in sections:
        before = rest[members][:, [first, second]] - rest[members][:, [first, second]].mean(axis=0)
        after = shape[members][:, [first, second]] - shape[members][:, [first, second]].mean(axis=0)
        sine = np.sum(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
        turns.append(np.arctan2(sine, np.sum(before * after)))
        heights.append(rest[members, axis].mean())
    return np.array(heights), np.degrees(np.unwrap(turns))


def twist_unevenness(heights, turns):
    """The largest distance, in degrees, of the turns from the straight line between the first and the last."""
    share = (heights - heights[0]) / (heights[-1] - heights[0])
    return float(np.abs(turns - (turns[0] + share * (turns[-1] - turns[0]))).max())


def asymmetry(shape, rest, normal_axis, diagonal):
    """How far a shape is from its mirror image in the plane that halves `rest` across an axis, over the diagonal.

    `rest` must be symmetric, vertex by vertex; ValueError where it is not.
    """
    middle = (rest[:, normal_axis].min() + rest[:, normal_axis].max()) / 2
    mirrored = rest.copy()
    mirrored[:, normal_axis] = 2 * middle - mirrored[:, normal_axis]
    distances = np.sum((mirrored[:, None] - rest[None]) ** 2, axis=2)
    partner = distances.argmin(axis=1)
    if distances.min(axis=1).max() > (1e-6 * diagonal) ** 2:
        raise ValueError("the rest shape is not symmetric")
    image = shape[partner].copy()
    image[:, normal_axis] = 2 * middle - image[:, normal_axis]
    return float(np.linalg.norm(image - shape, axis=1).max() / diagonal)


def ring_height(shape, faces, vertex):
    """How far a vertex stands out of its ring's mean, over the mean distance of the ring from there."""
    ring = np.setdiff1d(faces[(faces == vertex).any(axis=1)], [vertex])
    centre = shape[ring].mean(axis=0)
    return float(np.linalg.norm(shape[vertex] - centre) / np.linalg.norm(shape[ring] - centre, axis=1).mean())


def bump_errors(shape, rest, faces, inner, passes=30):
    """(height error, tilt) of the detail on a surface, over the rms of its height at rest, over vertices `inner`.

    Detail is what is left when the surface is smoothed (each vertex the mean of its ring, `passes` times); its height
    is measured along the smoothed surface's normal, so that bumps may turn with it. Height error: rms of the change.
    Tilt: rms change of the part along the surface: bumps that lean.
    """
    heights, along = zip(*(detail(points, faces, passes) for points in (rest, shape)), strict=True)
    scale = np.sqrt(np.mean(heights[0][inner] ** 2))
    height_error = np.sqrt(np.mean((heights[1] - heights[0])[inner] ** 2)) / scale
    return float(height_error), float(np.sqrt(np.mean((along[1] - along[0])[inner] ** 2)) / scale)


def detail(points, faces, passes):
    """(n,) parts of the detail along the smoothed surface's normals, and (n,) lengths of the rest of it."""
    pairs = unique_edges(faces)
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    degree = np.bincount(ends[:, 0], minlength=len(points))[:, None]
    smooth = points
    for _ in range(passes):
        sums = [np.bincount(ends[:, 0], smooth[ends[:, 1], k], len(points)) for k in range(3)]
        smooth = np.stack(sums, axis=1) / np.maximum(degree, 1)
    corners = smooth[faces]
    area_normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals = np.zeros_like(smooth)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], area_normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    heights = np.einsum("ij,ij->i", points - smooth, normals)
    return heights, np.linalg.norm(points - smooth - heights[:, None] * normals, axis=1)


def exponent(sizes, seconds):
    """The e of seconds ~ sizes ** e that fits best in logarithms (least squares); NaN for fewer than two sizes."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0]) if len(set(sizes)) > 1 else float("nan")
