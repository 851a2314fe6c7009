# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of another object, for a shape key of this one."""

import numpy as np

from ...errors import SceneError
from ...scene import key_reading, shape_keys, subject
from ...scene.core import motion
from ...scene.core.key_shapes import KeyShapes
from ...scene.core.point_sets import require_finite


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
