# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the handles are over time, whatever moves them: every frame is evaluated, and the controls are read then."""

import math
from dataclasses import dataclass

import bpy
import numpy as np

from ...errors import SceneError
from ...posing.bridge import targets
from ...scene import actions, rig_space, shape_keys
from ..core import bake_times


@dataclass(frozen=True, eq=False)
class Samples:
    """Of f frames and k anchors, in the order of `bind_input.anchors`.

    times    f float64: frames
    targets  f x k x 3 float64, in the object's own space at that frame
    weights  f x k float64, 0 to 1; None where all are 1
    notes    sentences on what an artist may not expect
    """

    times: np.ndarray
    targets: np.ndarray
    weights: np.ndarray | None
    notes: tuple


def sample(scene_name, find, bind_input, times):
    """Generator that yields the share that is done after each frame, and returns the Samples.

    find() returns the object, or raises SceneError if it is gone. Frames are visited in their order, as physics needs
    it, and the frame that was current is current again in the end, come what may. Handles that follow a shape key are
    sampled once: where the active shape key has them, whatever the values of shape keys are.

    @throws SceneError, with the frame.
    """
    obj = find()
    found = targets.handles_problem(obj)
    if found:
        raise SceneError(found)
    _require_evaluated(obj)
    pose_name = targets.pose_key(obj)
    pose = shape_keys.pose_positions(obj) if pose_name else None
    goals = np.empty((len(times), len(bind_input.anchors), 3))
    weights = np.ones(goals.shape[:2])

    def read(each, row, frame):
        _read(each, bind_input, pose, frame, goals[row], weights[row])

    yield from _visit(scene_name, find, times, read)
    return Samples(times, goals, None if (weights == 1.0).all() else weights, tuple(_notes(find(), pose_name)))


def sample_sliders(scene_name, find, names, times):
    """Generator as sample(), which returns f x k float64: the values of the shape keys `names`. @throws SceneError."""
    values = np.empty((len(times), len(names)))

    def read(obj, row, frame):
        blocks = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
        for column, name in enumerate(names):
            if name not in blocks:
                raise SceneError(f"At frame {bake_times.named(frame)} there is no shape key '{name}' any more")
            values[row, column] = blocks[name].value

    yield from _visit(scene_name, find, times, read)
    return values


def _visit(scene_name, find, times, read):
    """Generator of the share that is done: calls read(object, row, frame) at each frame, and goes back."""
    former = (bpy.data.scenes[scene_name].frame_current, bpy.data.scenes[scene_name].frame_subframe)
    try:
        for row, frame in enumerate(times):
            _set_frame(_scene(scene_name), frame)
            read(find(), row, frame)
            yield (row + 1) / len(times)
    except GeneratorExit:  # perhaps Blender is about to close the file: nothing may be evaluated any more
        _put_back(scene_name, former)
        raise
    except BaseException:
        _evaluate_again(scene_name, former)
        raise
    _evaluate_again(scene_name, former)


def _require_evaluated(obj):
    """@throws SceneError if the object or a control is disabled: Blender then leaves it where it is, without a word."""
    layer = bpy.context.view_layer.layer_collection
    controls = [handle.control for handle in targets.enabled_handles(obj) if handle.follows == 'CONTROL']
    for each in (obj, *controls):
        if each.hide_viewport or not _is_reached(layer, each):
            raise SceneError(
                f"'{each.name}' is disabled in viewports, or in a collection that is, so its animation does not run. "
                "Enable it (the monitor in the Outliner, the tick of its collection) and hide it by the eye instead"
            )


def _is_reached(layer_collection, obj):
    """Whether a collection that Blender evaluates has the object. Hidden by the eye is evaluated."""
    collection = layer_collection.collection
    if collection.hide_viewport:
        return False
    if not layer_collection.exclude and collection.objects.get(obj.name) == obj:
        return True
    return any(_is_reached(child, obj) for child in layer_collection.children)


def _read(obj, bind_input, pose, frame, goals, weights):
    """Fills k x 3 `goals` and k `weights`."""
    try:
        found = targets.handles_problem(obj)
        if found:
            raise SceneError(found)
        goals[:] = targets.positions(obj, bind_input, pose, rig_space.measure(obj))
        weights[:] = targets.influences(obj, bind_input)
    except SceneError as error:
        raise SceneError(f"At frame {bake_times.named(frame)}: {error}") from error
    except np.linalg.LinAlgError as error:
        raise SceneError(
            f"At frame {bake_times.named(frame)} '{obj.name}' or a control is scaled to nothing. Give it a size"
        ) from error


def _set_frame(scene, frame):
    whole = math.floor(frame)
    scene.frame_set(whole, subframe=float(frame - whole))


def _scene(name):
    scene = bpy.data.scenes.get(name)
    if scene is None:
        raise SceneError(f"The scene '{name}' is gone. Bake again")
    return scene


def _evaluate_again(scene_name, former):
    scene = bpy.data.scenes.get(scene_name)
    if scene is not None:
        scene.frame_set(former[0], subframe=former[1])


def _put_back(scene_name, former):
    scene = bpy.data.scenes.get(scene_name)
    if scene is not None:
        scene.frame_current, scene.frame_subframe = former


def _notes(obj, pose_name):
    handles = targets.enabled_handles(obj)
    if pose_name:
        names = [handle.name for handle in handles if handle.follows == 'SHAPE']
        yield (
            f"What follows a shape key stands still: {', '.join(names)} as in '{pose_name}', at all frames. Give them "
            "controls to animate them"
        )
    hard = [
        handle.name
        for handle in handles
        if handle.follows == 'CONTROL' and not handle.is_soft and _is_influence_animated(handle.control)
    ]
    if hard:
        yield f"Influence counts for soft handles only; {', '.join(hard)} held fully. Turn Soft on for them"


def _is_influence_animated(control):
    keyed, _values = actions.read_keys(control, "meanvalue.influence")
    return control.meanvalue.influence != 1.0 or len(keyed) > 0
