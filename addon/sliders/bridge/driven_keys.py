# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the handles of an object drive its shape keys, which then show the pose in place of the result."""

import numpy as np

from ...errors import SceneError, require_none
from ...scene import actions, key_marks, pose_key, shape_keys
from ...scene.key_marks import Role
from . import key_shapes

SHAPE, KEYS = 'SHAPE', 'SHAPE_KEYS'


def is_on(obj):
    return obj.meanvalue.drive == KEYS


def problem(obj):
    return None if is_on(obj) else "Handles drive no shape keys. Choose Shape Keys in Drive"


def names(obj):
    """Of the shape keys that show the pose, the corrective among them; none where the result does."""
    if not is_on(obj):
        return []
    driven = [slider.name for slider in key_shapes.sorted_out(obj)[0]]
    corrective = key_marks.only(obj.data.shape_keys, Role.CORRECTIVE)
    return driven if corrective is None else [*driven, corrective.name]


def positions(obj):
    """n x 3 float32: the mesh as its keys show it; None where the result does, or there are no keys to drive."""
    if not is_on(obj):
        return None
    try:
        shapes = key_shapes.gather(obj)
    except SceneError:  # told where they are to be driven
        return None
    return shapes.mixed(key_shapes.values(obj, shapes.names)).astype(np.float32)


def keyframe(obj):
    """Keys the values at the current frame. Returns what was keyed, in words; None where handles drive no keys.

    @throws SceneError.
    """
    if not is_on(obj):
        return None
    require_none(key_shapes.problem(obj))
    driven = names(obj)
    for name in driven:
        actions.insert_key(obj.data.shape_keys.key_blocks[name], "value")
    return len(driven), "shape key"


def chosen(obj):
    """Drive was chosen. The result, which posing by its shape writes, is not to be added to what keys show."""
    result = shape_keys.result(obj)
    if result is not None and result != obj.data.shape_keys.reference_key:
        pose_key.show(result, None if is_on(obj) else 1.0)
    obj.update_tag()
