# SPDX-License-Identifier: MPL-2.0
"""Meshes and motions that the benchmarks make themselves: a compact body and a thin bar, of any number of vertices."""

import numpy as np

from native.benchmarks import rigid
from native.benchmarks.peers.job import KEEP, RESTART, Job

BAR_LENGTH = 10.0  # its radius is 1
FRAMES = 100
JUMP_DEG, PATH_DEG = 120.0, 60.0


def sphere(frequency):
    """Unit sphere of 10 * frequency**2 + 2 vertices, outward triangles: an icosahedron's faces split and pushed out."""
    corners, faces = icosahedron()
    # A grid point is i a + j b + k c; the same sum of random corner keys modulo 2**64 is the same point.
    keys = np.random.default_rng(1).integers(0, 2**64, 12, np.uint64)
    rows, columns = np.meshgrid(np.arange(frequency + 1), np.arange(frequency + 1), indexing="ij")
    inside = rows + columns <= frequency
    weights = np.stack([frequency - rows - columns, rows, columns], axis=-1)[inside]
    number = np.full(inside.shape, -1)
    number[inside] = np.arange(len(weights))
    up = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:]], axis=-1)[inside[1:, :-1]]
    down = np.stack([number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1)[inside[1:, 1:]]
    local = np.concatenate([up, down])
    points = np.concatenate([weights @ corners[face] for face in faces])
    point_keys = np.concatenate([weights.astype(np.uint64) @ keys[face] for face in faces])
    _, first, back = np.unique(point_keys, return_index=True, return_inverse=True)
    triangles = back.reshape(-1)[np.concatenate([local + k * len(weights) for k in range(len(faces))])]
    vertices = points[first] / np.linalg.norm(points[first], axis=1, keepdims=True)
    return vertices, triangles.astype(np.int32)


def icosahedron():
    """(12, 3) corners and (20, 3) outward triangles."""
    golden = (1 + 5**0.5) / 2
    corners = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    corners = np.concatenate([corners, np.roll(corners, 1, axis=1), np.roll(corners, 2, axis=1)])
    faces = [
        (a, b, c) for a in range(12) for b in range(12) for c in range(12)
        if a < b and a < c and b != c and np.linalg.det(corners[[a, b, c]]) > 0
        and max(np.linalg.norm(corners[a] - corners[b]), np.linalg.norm(corners[b] - corners[c]),
                np.linalg.norm(corners[c] - corners[a])) < 2.01
    ]  # fmt: skip
    return corners / np.linalg.norm(corners[0]), np.array(faces)


def body(vertex_count):
    """A compact body with broad lobes and fine bumps: about so many vertices, well-shaped triangles, closed."""
    directions, triangles = sphere(max(2, round(((vertex_count - 2) / 10) ** 0.5)))
    x, y, z = directions.T
    lobes = 0.12 * np.sin(4 * x + 1) * np.cos(3 * y) + 0.12 * np.sin(5 * z + x)
    bumps = 0.01 * np.sin(25 * x) * np.sin(25 * y + 1) * np.sin(25 * z + 2)
    return directions * (1 + lobes + bumps)[:, None], triangles


def bar(vertex_count, bumpy=True):
    """A closed tube of radius 1 along z from 0 to BAR_LENGTH, with flat caps; all edges about equally long."""
    shares = BAR_LENGTH + 1.0  # the two caps have the area of a unit length of the side
    around = 2 * max(3, round((vertex_count * 2 * np.pi * 3**0.5 / 2 / shares) ** 0.5 / 2))
    spacing = 2 * np.pi / around
    cap_rings = max(2, round(1 / (spacing * 3**0.5 / 2)))
    side_rings = 2 * max(1, round(BAR_LENGTH / (spacing * 3**0.5 / 2) / 2)) + 1  # odd: mirror-symmetric
    cap = [(0.0, k / cap_rings, 2 * max(3, round(around * k / cap_rings / 2))) for k in range(1, cap_rings)]
    rings = cap + [(BAR_LENGTH * k / (side_rings - 1), 1.0, around) for k in range(side_rings)]
    rings += [(BAR_LENGTH, radius, count) for _, radius, count in reversed(cap)]
    points, triangles, first = [np.zeros((1, 3))], [], 1
    angles = []
    for level, (height, radius, count) in enumerate(rings):
        # Every second ring is turned by half an edge; counted from the ends, so that the two ends are alike.
        turn = 0.5 * (min(level, len(rings) - 1 - level) % 2)
        angles.append((np.arange(count) + turn) / count)
        angle = 2 * np.pi * angles[-1]
        points.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(count, height)], axis=1))
        if level:
            triangles.append(zipper(angles[-2], angles[-1], first - len(angles[-2]), first))
        first += count
    points.append(np.array([[0, 0, BAR_LENGTH]]))
    triangles.append(fan(len(angles[0]), 0, 1)[:, ::-1])
    triangles.append(fan(len(angles[-1]), first, first - len(angles[-1])))
    vertices = np.concatenate(points)
    if bumpy:
        around_angle = np.arctan2(vertices[:, 1], vertices[:, 0])
        bumps = 1 + 0.06 * np.sin(5 * around_angle) * np.sin(3 * vertices[:, 2])
        vertices[:, :2] *= bumps[:, None]
    return vertices, np.concatenate(triangles).astype(np.int32)


def zipper(lower, upper, lower_first, upper_first):
    """Triangles between two rings of vertices at angles in turns, counter-clockwise from above, facing outwards.

    Going round, the next edge is that of the ring whose edge has its middle first.
    """
    middles = [np.append(ring[1:], ring[0] + 1) + ring for ring in (lower, upper)]
    low, high = np.arange(len(lower)), np.arange(len(upper))
    apex = np.searchsorted(middles[1], middles[0]) % len(upper)
    base = np.searchsorted(middles[0], middles[1], side="right") % len(lower)
    one = np.stack([low + lower_first, (low + 1) % len(lower) + lower_first, apex + upper_first], axis=1)
    other = np.stack([(high + 1) % len(upper) + upper_first, high + upper_first, base + lower_first], axis=1)
    return np.concatenate([one, other])


def fan(count, centre, first):
    """Triangles from a centre to a ring of `count` vertices, counter-clockwise from above."""
    ring = np.arange(count)
    return np.stack([np.full(count, centre), ring + first, (ring + 1) % count + first], axis=1)


def bend(angle_deg, shift, length=BAR_LENGTH):
    """(rotation, shift) of the bar's upper end when the bar's middle line is bent to an arc of its own length."""
    angle = np.radians(angle_deg)
    rotation = rigid.rotation_about([1, 0, 0], -angle_deg)  # towards +y
    radius = length / angle if angle else 0.0
    end = [0, radius * (1 - np.cos(angle)), radius * np.sin(angle)] if angle else [0, 0, length]
    return rotation, np.array(end) - rotation @ [0, 0, length] + shift


def turn(centre, axis, angle_deg, shift):
    """(rotation, shift) of a turn about an axis through a centre, then a shift."""
    rotation = rigid.rotation_about(axis, angle_deg)
    return rotation, centre - rotation @ centre + shift


def speed_job(shape, vertex_count):
    """The job of bench_speed: a jump from rest, then FRAMES frames of a smooth path that starts at rest.

    shape: "bar": bent by 120 degrees; path: bent up to 60 degrees and moved sideways. "body": its top turned by 120
    degrees about the vertical and lifted; path: turned by 60 degrees about a slanted axis and moved.
    """
    times = np.arange(1, FRAMES + 1) / FRAMES
    if shape == "bar":
        vertices, faces = bar(vertex_count)
        fixed, handle = vertices[:, 2] < 0.5, vertices[:, 2] > BAR_LENGTH - 0.5
        motions = [bend(JUMP_DEG, np.zeros(3)), *[bend(PATH_DEG * t, np.array([1.0, 0, 0]) * t) for t in times]]
    else:
        vertices, faces = body(vertex_count)
        height = vertices[:, 2] / np.linalg.norm(vertices, axis=1)
        fixed, handle = height < -0.9, height > 0.9
        centre = vertices[handle].mean(axis=0)
        motions = [turn(centre, [0, 0, 1], JUMP_DEG, np.array([0, 0, 0.3]))]
        motions += [turn(centre, [1, 0, 1], PATH_DEG * t, np.array([0.2, 0.1, 0.3]) * t) for t in times]
    anchors = np.flatnonzero(fixed | handle)
    moving = handle[anchors]
    rest = vertices[anchors]
    targets = np.repeat(rest[None], len(motions), axis=0)
    for step, (rotation, shift) in enumerate(motions):
        targets[step, moving] = rest[moving] @ rotation.T + shift
    plan = np.zeros(len(motions), np.int32)
    plan[:2] = RESTART
    plan[[0, 5]] |= KEEP  # to see that it is a shape at all
    return Job(vertices, faces, anchors, np.where(moving, 0, -1), targets, plan)
