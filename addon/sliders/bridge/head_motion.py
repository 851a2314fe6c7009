# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of the whole head as keys of the object's location and rotation."""

import numpy as np
from mathutils import Matrix

from ... import wording
from ...errors import SceneError
from ...scene import actions

#: How unequal the scales of an object may be.
EVEN = 1e-3

ROTATIONS = {'QUATERNION': "rotation_quaternion", 'AXIS_ANGLE': "rotation_axis_angle"}


def require_room(obj, replace):
    """@throws SceneError if the object can't take the motion, or would lose its own."""
    scales = np.abs(obj.scale)
    if scales.min() < (1.0 - EVEN) * scales.max():
        raise SceneError(
            f"'{obj.name}' is scaled unevenly, so it can't turn as the head does. Apply the scale (Ctrl A), or choose "
            "another Head Motion"
        )
    names = [path for path in _paths(obj) if any(len(actions.read_keys(obj, path, index)[0]) for index in range(3))]
    if names and not replace:
        words = wording.listed("location" if name == "location" else "rotation" for name in names)
        raise SceneError(
            f"The {words} of '{obj.name}' is animated already. Turn on Replace to write over that, or choose another "
            "Head Motion"
        )


def write(obj, frames, bases, transforms):
    """Keys at `frames` (f,): the object's own transforms `bases` (f, 4, 4), and in them the rigid ones of the head."""
    location_path, rotation_path = _paths(obj)
    former = obj.location.copy(), tuple(getattr(obj, rotation_path)), obj.scale.copy()
    locations, rotations = [], []
    for base, transform in zip(bases, transforms, strict=True):
        obj.matrix_basis = Matrix(base @ transform)  # Blender minds rotation modes and delta transforms
        locations.append(obj.location.copy())
        rotations.append(_turned_on(getattr(obj, rotation_path), rotations[-1] if rotations else None))
    obj.location, obj.scale = former[0], former[2]
    setattr(obj, rotation_path, former[1])
    actions.write_vector(obj, location_path, frames, np.array(locations))
    actions.write_vector(obj, rotation_path, frames, np.array(rotations))


def _turned_on(rotation, last):
    """A copy of a rotation in the numbers that are nearest to those of the last one."""
    if not hasattr(rotation, "make_compatible"):  # an axis with an angle
        return tuple(rotation)
    turned = rotation.copy()
    if last is not None:
        turned.make_compatible(last)
    return turned


def _paths(obj):
    return "location", ROTATIONS.get(obj.rotation_mode, "rotation_euler")
