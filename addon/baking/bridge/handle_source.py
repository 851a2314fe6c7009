# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the handles are over time, whatever moves them: as of a rooms.Bakeable."""

import json

import numpy as np

from ...errors import SceneError, require_none
from ...posing.bridge import targets
from ...posing.bridge.scene_input import Posing
from ...scene import actions, baked, frames, key_marks, rig_space, vertex_groups, views
from .clips import HandleClip


def bind(obj):
    """@throws SceneError, StaleBindingError."""
    posing = Posing(obj)
    require_evaluated(obj)
    return posing


def row(obj, bind_input):
    """float64: targets and influences, k x 4; how much the pose counts, and keys beside it. @throws SceneError."""
    require_none(targets.handles_problem(obj))
    try:
        placed = targets.positions(obj, bind_input, rig_space.measure(obj))
    except np.linalg.LinAlgError as error:
        raise SceneError(f"'{obj.name}' or a control is scaled to nothing. Give it a size") from error
    places, _held_back = targets.within_reach(obj, bind_input, placed)
    handles = np.column_stack([places, targets.influences(obj, bind_input)])
    keys, fading = obj.data.shape_keys, key_marks.replacing(obj)
    off = json.loads(obj.meanvalue.baked.muted or "{}")  # by the last bake, until this one is done
    shown = {*fading, *key_marks.of_role(keys, key_marks.Role.KEPT)} if keys else ()
    kept = {key.name: _value(key, off) for key in shown if key.name in off or (key in fading and not key.mute)}
    values = {**dict(rig_space.sliders(obj)), **kept}
    beside = [values.get(key.name, 0.0) for key in keys.key_blocks] if keys else []
    return np.concatenate([handles.ravel(), [1.0 - np.clip(sum(_value(key, off) for key in fading), 0.0, 1.0)], beside])


def _value(key, off):
    """What it shows but for a bake, which has told in `off` what it turned off."""
    is_moved = actions.driver_of(key) or len(actions.read_keys(key.id_data, key.path_from_id("value"))[0])
    return key.value if is_moved or not isinstance(off, dict) else off.get(key.name, key.value)


def clip(obj, bind_input, rows, times, portable=False, target=baked.TO_CACHE):
    """HandleClip of f rows at f times. A cache plays in place of all shape keys, bones in place of kept poses."""
    keyed, keys, count = frames.lone_keys(animated(obj)), obj.data.shape_keys, 4 * len(bind_input.anchors)
    kept = tuple(row for row, time in enumerate(times) if time in keyed)
    handles, counts = rows[:, :count].reshape(len(rows), -1, 4), rows[:, count:]
    weights = None if (handles[..., 3] == 1.0).all() else np.ascontiguousarray(handles[..., 3])
    shown, poses = np.flatnonzero(counts[:, 1:].any(axis=0)), key_marks.of_role(keys, key_marks.Role.KEPT)
    if target != baked.TO_CACHE:
        shown = [each for each in shown if target == baked.TO_BONES and keys.key_blocks[each] in poses]
    shapes = vertex_groups.shapes_of(obj, [vertex_groups.slider_of(obj, keys.key_blocks[each]) for each in shown])
    beside = np.array([shapes.offset(number) for number in range(len(shown))], np.float32)
    counts = counts[:, [0, *(1 + each for each in shown)]]
    more = (counts, beside) if len(beside) or counts.min() < 1.0 else ()
    return HandleClip(bind_input, np.ascontiguousarray(handles[..., :3]), weights, portable, kept, *more)


def animated(obj):
    """The datablocks that move the handles: the object, its rigs, the controls, and what these hang on or follow."""
    return frames.movers([obj, *rig_space.armatures(obj), *(handle.control for handle in targets.moved_handles(obj))])


def require_evaluated(obj):
    """@throws SceneError if the object or a control is disabled: Blender then leaves it where it is, without a word."""
    for each in (obj, *(handle.control for handle in targets.moved_handles(obj))):
        if not views.is_evaluated(each):
            raise SceneError(f"'{each.name}' is disabled, so its animation does not run. {views.ENABLE}")
