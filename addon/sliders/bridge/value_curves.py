# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves on the values of shape keys that the mesh has."""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import actions, shape_keys


def problem(obj):
    """Why `obj` has no shape keys with values to animate, or None. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    if keys is None or len(keys.key_blocks) < 2:
        return f"'{obj.name}' has no shape keys besides the Basis. Choose the mesh that has them"
    return None if keys.use_relative else shape_keys.ABSOLUTE


def require_room(obj, names, replace):
    """@throws SceneError if values of the shape keys `names` are animated, and not to be replaced."""
    keys = obj.data.shape_keys
    animated = [name for name in names if len(actions.read_keys(keys, keys.key_blocks[name].path_from_id("value"))[0])]
    if animated and not replace:
        raise SceneError(
            f"{wording.quoted(animated)} {'is' if len(animated) == 1 else 'are'} animated already. Turn on Replace to "
            "write over that animation, or give the shape keys another action first"
        )


def write(obj, curves, replace):
    """curves: {name of a shape key: (frames, values)}, n each. Returns notes.

    @throws SceneError, with nothing changed, if values are animated and not to be replaced, or nothing can be written.
    """
    keys = obj.data.shape_keys
    left_out = [name for name in curves if actions.driver_of(keys.key_blocks[name])]
    writable = {name: curve for name, curve in curves.items() if name not in left_out}
    if not writable:
        raise SceneError(f"Drivers set the values of {wording.quoted(left_out)}. Delete the drivers first")
    require_room(obj, writable, replace)
    for name, (frames, values) in writable.items():
        actions.write_curve(keys, keys.key_blocks[name].path_from_id("value"), 0, frames, values)
    return list(_notes(keys, writable, left_out))


def _notes(keys, curves, left_out):
    if left_out:
        yield f"Drivers set {wording.quoted(left_out)}: left alone"
    muted = [name for name in curves if keys.key_blocks[name].mute]
    if muted:
        yield f"{wording.quoted(muted)} {'is' if len(muted) == 1 else 'are'} muted, so the values do not show"
    beyond = [name for name, (_frames, values) in curves.items() if _is_beyond(keys.key_blocks[name], values)]
    if beyond:
        yield f"Values of {wording.quoted(beyond)} are beyond the range, which holds them. Widen Range Min and Max"


def _is_beyond(key, values):
    margin = 1e-4
    return np.min(values) < key.slider_min - margin or np.max(values) > key.slider_max + margin
