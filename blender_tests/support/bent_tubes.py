# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed tube along z, bent, twisted, or posed by an armature: shapes of which every in-between is known."""

import numpy as np

from native.benchmarks import rigid
from native.benchmarks.generated_meshes import BAR_LENGTH, bar


def tube(vertex_count=1200, radius=1.0):
    """(vertices, faces): the tube of generated_meshes, as thin as asked for."""
    vertices, faces = bar(vertex_count)
    return vertices * [radius, radius, 1.0], faces


def bent(vertices, angle_deg):
    """The middle line an arc of its own length, cross-sections across it."""
    angle = np.radians(angle_deg)
    if angle == 0.0:
        return vertices.copy()
    radius = BAR_LENGTH / angle
    along = vertices[:, 2] / BAR_LENGTH * angle
    x, y = vertices[:, 0], vertices[:, 1]
    return np.stack([x, radius - (radius - y) * np.cos(along), (radius - y) * np.sin(along)], axis=1)


def elbow(vertices, angle_rad, width):
    """All of the bend, about x, within `width` around the middle of its height."""
    middle = 0.5 * (vertices[:, 2].min() + vertices[:, 2].max())
    height = vertices[:, 2] - middle
    turn = angle_rad * np.clip(height / width + 0.5, 0.0, 1.0)
    y = np.cos(turn) * vertices[:, 1] - np.sin(turn) * height
    return np.stack([vertices[:, 0], y, np.sin(turn) * vertices[:, 1] + np.cos(turn) * height + middle], axis=1)


def twisted(vertices, angle_deg):
    """Cross-sections turned evenly along the middle line."""
    angle = np.radians(angle_deg) * vertices[:, 2] / BAR_LENGTH
    x, y, z = vertices.T
    return np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, z], axis=1)


def posed(vertices, joints, width=2.0):
    """By an armature with linear-blend skinning. joints: (height, axis, angle in degrees) from below; a bone goes over
    into the next, smoothly, over `width`."""
    heights = vertices[:, 2]
    rotation, shift = np.eye(3), np.zeros(3)
    bones, begun = [(rotation, shift)], [np.ones(len(vertices))]
    for height, axis, angle in joints:
        turn, centre = rigid.rotation_about(axis, angle), np.array([0.0, 0.0, height])
        rotation, shift = rotation @ turn, rotation @ (centre - turn @ centre) + shift
        bones.append((rotation, shift))
        share = np.clip((heights - height) / width + 0.5, 0, 1)
        begun.append(share**2 * (3 - 2 * share))
    begun.append(np.zeros(len(vertices)))
    shape = np.zeros_like(vertices)
    for number, (rotation, shift) in enumerate(bones):
        shape += (begun[number] - begun[number + 1])[:, None] * (vertices @ rotation.T + shift)
    return shape


def fitted(shape, onto):
    """A shape moved rigidly onto another one."""
    centre, other = shape.mean(axis=0), onto.mean(axis=0)
    rotation = rigid.nearest_rotations(((onto - other).T @ (shape - centre))[None])[0]
    return (shape - centre) @ rotation.T + other


def rms(shape, truth):
    """Root mean square distance after the best rigid fit, in diagonals of the truth."""
    return np.sqrt(((fitted(shape, truth) - truth) ** 2).sum(axis=1).mean()) / diagonal(truth)


def diagonal(shape):
    return float(np.linalg.norm(np.ptp(shape, axis=0)))
