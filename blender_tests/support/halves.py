# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a body with a Mirror modifier, and a whole one that is symmetric by itself, with pins and handles."""

import bpy
import numpy as np

from . import handles, meshes, mirrored_bodies, steps
from .baking import rest
from .handles import move, shown, update  # noqa: F401  for tests

RESULT = handles.RESULT


def half(axes=(0,), cells=8, live=True, name="Half", merge=True, clip=True, shift=(0.0, 0.0, 0.0)):
    """(object, control): a pin at the bottom and a handle with a control at the top, both over the seam."""
    vertices, triangles = mirrored_bodies.body(cells)
    numbers, own = mirrored_bodies.part(vertices, triangles, axes)
    obj = meshes.make_object((vertices[numbers] + shift).tolist(), own.tolist(), name)
    add_mirror(obj, axes, merge, clip)
    return obj, add_handles(obj, live)


def whole(cells=8, live=True, name="Whole"):
    """(object, control): as half(), but the handle is at the right side."""
    vertices, triangles = mirrored_bodies.body(cells)
    obj = meshes.make_object(vertices.tolist(), triangles.tolist(), name)
    return obj, add_handles(obj, live, np.flatnonzero(vertices[:, 0] > 0.7))


def add_mirror(obj, axes=(0,), merge=True, clip=True):
    modifier = obj.modifiers.new("Mirror", 'MIRROR')
    modifier.use_axis = [axis in axes for axis in range(3)]
    modifier.use_mirror_merge, modifier.use_clip = merge, clip
    return modifier


def add_handles(obj, live=True, handle=None):
    positions = np.array([tuple(vertex.co) for vertex in obj.data.vertices])
    top, bottom = (np.flatnonzero(positions[:, 2] * side > 1.5) for side in (1.0, -1.0))
    middle = np.flatnonzero(np.abs(positions[:, 2]) < 0.1)
    holds = bottom if len(bottom) else middle
    steps.add_handle(obj, "Bottom", holds.tolist(), pin=True)
    steps.add_handle(obj, "Top", (top if handle is None else handle).tolist(), live=live)
    update()
    return bpy.context.object


def turn(control, angle, axis=0):
    control.rotation_mode = 'XYZ'
    control.rotation_euler[axis] += angle
    update()


def seam(obj, axis=0):
    """Indices of the vertices in the plane at rest."""
    return np.flatnonzero(np.abs(rest(obj)[:, axis]) < 1e-6)


def size(obj):
    return float(np.linalg.norm(np.ptp(rest(obj), axis=0)))


def asymmetry(obj, positions, axis=0):
    """The most that a vertex is from the mirror image of its twin, which is found by the rest shape."""
    flip = np.where(np.arange(3) == axis, -1.0, 1.0)
    resting = np.round(rest(obj).astype(float), 4)
    numbers = {tuple(place): number for number, place in enumerate(resting + 0.0)}
    twins = [numbers[tuple(place)] for place in resting * flip + 0.0]
    return float(np.abs(positions[twins] * flip - positions).max())
