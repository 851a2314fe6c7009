# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of another object, for a shape key of this one."""

import numpy as np

from ...errors import SceneError
from ...scene import key_reading, mesh_arrays, shape_keys, subject, vertex_groups
from ...scene.core import motion
from ...scene.core.key_shapes import KeyShapes
from ...scene.core.point_sets import require_finite
from ..core import grafting


def in_place(source, obj):
    """(n x 3: the shape of `source` in the space of `obj`, whether its origin was laid on that of `obj`).

    It is the rest shape with the shape keys as they are set and no modifiers, turned and scaled as it is to be seen. It
    counts where it stands, or as if it stood at the same origin, as one who stands beside does: whichever is nearer to
    the rest shape. @throws SceneError.
    """
    keys = source.data.shape_keys
    if source.data.is_editmode:
        raise SceneError(f"'{source.name}' is in Edit Mode. Leave that first")
    keys = keys.key_blocks[1:] if keys is not None and keys.use_relative else ()
    keys = [key for key in keys if key.value and not key.mute]
    shapes = KeyShapes(**key_reading.parts(source, [key_reading.slider_of(source, key) for key in keys]))
    shape = shapes.mixed([key.value for key in keys])
    require_finite(shape, f"shape of '{source.name}'")
    shape = shape.astype(np.float32)
    own, other = subject.to_world(obj), subject.to_world(source)
    if motion.same(own, other):
        return shape, False
    matrix = np.linalg.inv(own) @ other
    rest = shape_keys.rest_positions(obj.data)
    stands, laid = motion.apply(matrix, shape), motion.apply(motion.affine(matrix[:3, :3]), shape)
    is_laid = bool(np.linalg.norm(laid - rest) < np.linalg.norm(stands - rest))
    return laid if is_laid else stands, is_laid


def add_key(obj, shape, name, value, group=""):
    """A shape key of `obj`, with the Basis if that is missing. group: a vertex group that says where it counts.

    A part is placed so that its border meets that of the mesh. Returns the name of the key; the active key stays.
    """
    if group:
        mask = vertex_groups.weights(obj, [group])[group]
        if not mask.any():
            raise SceneError(f"The vertex group '{group}' has no vertices with a weight above zero. Assign the part")
        rest = shape_keys.rest_positions(obj.data)
        shape = grafting.placed(shape, rest, grafting.border(mask, mesh_arrays.edges(obj.data)))
    made = shape_keys.add_shape(obj, name, np.asarray(shape, np.float32))
    made.vertex_group = group
    made.value = value
    return made.name
