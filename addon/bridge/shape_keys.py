# SPDX-License-Identifier: GPL-3.0-or-later
"""The rest shape, the artist's pose and the result, all of them shape keys."""

import numpy as np

from .. import compat, ids
from ..core.bind_input import require_finite
from ..errors import SceneError
from . import mesh_arrays


def positions(key):
    """n x 3 float32 of one shape key."""
    store, name = compat.key_store(key)
    result = np.empty(3 * len(store), np.float32)
    store.foreach_get(name, result)
    return result.reshape(-1, 3)


def rest_positions(mesh):
    """n x 3 float32: the reference key (Basis) if there are shape keys, else the vertices."""
    if mesh.shape_keys is None:
        return mesh_arrays.vertex_positions(mesh)
    rest = positions(mesh.shape_keys.reference_key)
    if len(rest) != len(mesh.vertices):
        raise SceneError(
            f"The Basis shape key has {len(rest):,} points, the mesh has {len(mesh.vertices):,} vertices. "
            "Enter and leave Edit Mode once, so that Blender makes them agree"
        )
    return rest


def pose_problem(obj):
    """Why the active shape key cannot give the targets, or None. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    advice = "Press Add Pose Key and move the anchor vertices of that key in Edit Mode"
    if keys is None:
        return f"There is no shape key to take the targets from. {advice}"
    if not keys.use_relative:
        return "The shape keys are absolute. Turn on Relative in Object Data Properties > Shape Keys"
    active = obj.active_shape_key
    if active is None or active == keys.reference_key:
        return (
            f"The active shape key is the rest shape itself, so nothing is posed. {advice}, "
            "or choose the key that poses them"
        )
    return None


def result_problem(obj):
    """Why the result cannot go to the shape key that the settings name, or None. Cheap enough for drawing."""
    name = obj.meanvalue.result_key
    if not name.strip():
        return "The result has no name. Fill in Result, the shape key to write"
    keys = obj.data.shape_keys
    if keys is not None and name == keys.reference_key.name:
        return f"'{name}' is the rest shape and must not be overwritten. Give Result another name"
    return None


def pose_positions(obj):
    """n x 3 float32 of the active shape key, which holds the targets.

    @throws SceneError if there is none, or the result has nowhere to go.
    """
    problem = pose_problem(obj) or result_problem(obj)
    if problem:
        raise SceneError(problem)
    pose = positions(obj.active_shape_key)
    require_finite(pose[:], f"shape key '{obj.active_shape_key.name}'")
    return pose


def write_result(obj, result):
    """Writes n x 3 float32 `result` to the result key and shows it; makes the key if it is missing.

    The active key stays active. Returns notes on what else had to change, as sentences.
    """
    mesh = obj.data
    pose_key = obj.active_shape_key
    active_index = obj.active_shape_key_index
    name = obj.meanvalue.result_key
    key = mesh.shape_keys.key_blocks.get(name)
    if key is None:
        key = obj.shape_key_add(name=name, from_mix=False)
        pose_key = mesh.shape_keys.key_blocks[active_index]  # adding a key may have moved the others in memory
    store, attribute = compat.key_store(key)
    store.foreach_set(attribute, result.ravel())
    _show_fully(mesh.shape_keys, key)
    notes = []
    former = mesh.shape_keys.key_blocks.get(obj.meanvalue.former_result)
    for other in (pose_key, former):
        if other is not None and other != key and not other.mute:
            other.mute = True
            notes.append(f"Shape key '{other.name}' is muted, so that it is not added to '{key.name}'")
    obj.meanvalue.former_result = key.name
    obj.active_shape_key_index = active_index
    mesh.update_tag()  # Blender 3.4 does not notice foreach_set on a shape key
    if obj.show_only_shape_key and key != pose_key:
        notes.append(f"'{pose_key.name}' is pinned: turn off Shape Key Lock to see '{key.name}'")
    return notes


def _show_fully(keys, key):
    """So that the object takes exactly the key's positions, whatever was set on it before."""
    key.relative_key = keys.reference_key
    key.vertex_group = ""
    key.mute = False
    key.slider_min = min(key.slider_min, 0.0)
    key.slider_max = max(key.slider_max, 1.0)
    key.value = 1.0


def add_pose_key(obj):
    """A new key in the rest shape, active and shown, for the artist to move anchors in; the Basis too if missing."""
    mesh = obj.data
    if mesh.shape_keys is None:
        obj.shape_key_add(name=ids.BASIS_KEY, from_mix=False)
    keys = mesh.shape_keys
    if not keys.use_relative:
        raise SceneError("The shape keys are absolute. Turn on Relative in Object Data Properties > Shape Keys")
    rest = positions(keys.reference_key)
    key = obj.shape_key_add(name=ids.POSE_KEY, from_mix=False)
    store, attribute = compat.key_store(key)
    store.foreach_set(attribute, rest.ravel())
    key.value = 1.0
    obj.active_shape_key_index = len(keys.key_blocks) - 1
    mesh.update_tag()
    return key.name
