# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the handles are over time, whatever moves them: as of a rooms.Bakeable."""

import numpy as np

from ...errors import SceneError, require_none
from ...posing.bridge import targets
from ...posing.bridge.scene_input import Posing
from ...scene import frames, pose_key, rig_space, views
from .clips import HandleClip


def bind(obj):
    """@throws SceneError, StaleBindingError."""
    posing = Posing(obj)
    require_evaluated(obj)
    return posing


def row(obj, bind_input):
    """k x 5 float64: targets and influences of the anchors, and the share of the pose. @throws SceneError."""
    require_none(targets.handles_problem(obj))
    try:
        placed = targets.positions(obj, bind_input, rig_space.measure(obj))
    except np.linalg.LinAlgError as error:
        raise SceneError(f"'{obj.name}' or a control is scaled to nothing. Give it a size") from error
    places, _held_back = targets.within_reach(obj, bind_input, placed)
    left = 1.0 - np.clip(sum(key.value for key in pose_key.replacing(obj)), 0.0, 1.0)
    return np.column_stack([places, targets.influences(obj, bind_input), np.full(len(places), left)])


def clip(obj, bind_input, rows, times, portable=False):
    """HandleClip of rows, f x k x 5, at f times."""
    keyed = frames.lone_keys(animated(obj))
    kept = tuple(row for row, time in enumerate(times) if time in keyed)
    weights = None if (rows[..., 3] == 1.0).all() else np.ascontiguousarray(rows[..., 3])
    return HandleClip(bind_input, np.ascontiguousarray(rows[..., :3]), weights, portable, kept)


def animated(obj):
    """The datablocks that move the handles: the object, its rigs, the controls, and what these hang on or follow."""
    return frames.movers([obj, *rig_space.armatures(obj), *(handle.control for handle in targets.moved_handles(obj))])


def require_evaluated(obj):
    """@throws SceneError if the object or a control is disabled: Blender then leaves it where it is, without a word."""
    for each in (obj, *(handle.control for handle in targets.moved_handles(obj))):
        if not views.is_evaluated(each):
            raise SceneError(f"'{each.name}' is disabled, so its animation does not run. {views.ENABLE}")
