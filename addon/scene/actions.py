# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves in bulk, for objects, shape keys (`mesh.shape_keys`) and all else that can be animated."""

import contextlib

import bpy
import numpy as np
from mathutils import Matrix

from .. import compat, ids
from ..errors import SceneError


def write_curve(id_block, data_path, index, frames, values, interpolation='LINEAR'):
    """Replaces the F-curve of one number by one with these keys; by none if there are none.

    frames, values: n each; frames ascending. index: of the number in an array property, 0 for a single one.
    interpolation: 'CONSTANT', 'LINEAR', 'BEZIER', ... from each key to the next. Handles are Blender's own (clamped),
    so that keys whose interpolation is changed later behave. The action is made if there is none.
    """
    curves = compat.curves_to_write(id_block, own_action(id_block))
    former = curves.find(data_path, index=index)
    if former is not None:
        curves.remove(former)
    if len(frames) == 0:
        return
    coordinates = np.empty((len(frames), 2), np.float32)
    coordinates[:, 0], coordinates[:, 1] = frames, values
    curve = curves.new(data_path, index=index)
    keys = curve.keyframe_points
    keys.add(len(coordinates))
    keys.foreach_set("co", coordinates.ravel())
    number = bpy.types.Keyframe.bl_rna.properties["interpolation"].enum_items[interpolation].value
    keys.foreach_set("interpolation", np.full(len(coordinates), number, np.int32))
    curve.update()


def write_vector(id_block, data_path, frames, values):
    """write_curve() for each column of `values`, n x c."""
    for index in range(values.shape[1]):
        write_curve(id_block, data_path, index, frames, values[:, index])


def motion_paths(mover):
    """What Blender calls location and rotation of an object or a pose bone."""
    return mover.path_from_id("location"), mover.path_from_id(rotation_path(mover))


def write_motion(mover, frames, matrices, moves=True):
    """Keys of an object or a pose bone at `frames` (f,) for what it does of itself, f of 4 x 4. moves: location too."""
    rotation_name = rotation_path(mover)
    former = mover.location.copy(), tuple(getattr(mover, rotation_name)), mover.scale.copy()
    locations, rotations = [], []
    for matrix in matrices:
        mover.matrix_basis = Matrix(matrix)  # Blender minds rotation modes and delta transforms
        locations.append(mover.location.copy())
        turned = getattr(mover, rotation_name)
        is_axis = not hasattr(turned, "make_compatible")  # with an angle
        rotations.append(tuple(turned) if is_axis else turned.copy())
        if not is_axis and len(rotations) > 1:
            rotations[-1].make_compatible(rotations[-2])  # in the numbers that are nearest to those of the last one
    mover.location, mover.scale = former[0], former[2]
    setattr(mover, rotation_name, former[1])
    for path, values in tuple(zip(motion_paths(mover), (locations, rotations), strict=True))[not moves :]:
        write_vector(mover.id_data, path, frames, np.array(values))


def read_keys(id_block, data_path, index=0):
    """(frames, values), n float64 each, of the keys of an F-curve; empty if there is none. What has no action has those
    of its strips in the NLA, lower tracks first."""
    animation = id_block.animation_data
    if animation is None or animation.action is not None or not animation.nla_tracks:
        return _keys(compat.curves_to_read(id_block), data_path, index)
    strips = [each for track in animation.nla_tracks if not track.mute for each in track.strips if not each.mute]
    found = [(np.empty(0), np.empty(0))]
    for strip in strips:
        frames, values = _keys(compat.curves_played(strip), data_path, index)
        is_played = (frames >= strip.action_frame_start) & (frames <= strip.action_frame_end)
        at = strip.frame_start + strip.scale * (frames - strip.action_frame_start)
        found.append((at[is_played], values[is_played]))
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


def _keys(curves, data_path, index):
    curve = curves.find(data_path, index=index) if curves else None
    return keys_of(curve) if curve is not None else (np.empty(0), np.empty(0))


def keys_of(curve):
    """(frames, values), n float64 each, of the keys of an F-curve."""
    coordinates = np.empty(2 * len(curve.keyframe_points), np.float32)
    curve.keyframe_points.foreach_get("co", coordinates)
    return tuple(coordinates.reshape(-1, 2).T.astype(np.float64))


def driver_of(key):
    """What drives the value of a shape key, as an F-curve, or None."""
    animation = key.id_data.animation_data
    return animation and animation.drivers.find(key.path_from_id("value"))


def source_of(key):
    """(datablock, path) of the first variable of the driver of a shape key, or None."""
    curve = driver_of(key)
    target = curve.driver.variables[0].targets[0] if curve and len(curve.driver.variables) else None
    return target and (target.id, target.data_path)


def drive(owner, sources, expression, path="value"):
    """sources: {variable: a shape key whose value it has, or "mute" if it is called so; or (datablock, path); or (rig,
    bone, channel of its own turn, how that is split)}. Returns the F-curve."""
    curve = owner.driver_add(path)
    driver = curve.driver
    driver.type = 'SCRIPTED'  # Blender evaluates sums and products itself: no Python, no permission needed
    for name, source in sources.items():
        variable = driver.variables.new()
        variable.name, target = name, variable.targets[0]
        if isinstance(source, bpy.types.ShapeKey):
            target.id_type = 'KEY'
            source = source.id_data, source.path_from_id("mute" if name == "mute" else "value")
        if len(source) == 2:
            target.id, target.data_path = source
        else:
            variable.type, target.transform_space = 'TRANSFORMS', 'LOCAL_SPACE'
            target.id, target.bone_target, target.transform_type, target.rotation_mode = source
    driver.expression = expression
    return curve


def copy_driver(former, key, own):
    """Drives a shape key as another is driven, or not. own: {datablock: what is read in its place, if it has that}.
    Returns whether it does: what Drive by Pose made is not copied, as it goes when that is pressed on the other."""
    curve, keys = driver_of(former), key.id_data
    key.driver_remove("value")
    if not curve or (source_of(former) or ("", ""))[1].startswith(f'["{ids.DRIVE_BY_POSE} '):
        return not curve
    copy = (keys.animation_data or keys.animation_data_create()).drivers.from_existing(src_driver=curve)
    copy.data_path = key.path_from_id("value")
    for target in (each for variable in copy.driver.variables for each in variable.targets):
        with contextlib.suppress(ValueError):
            if target.id in own and (not target.data_path or own[target.id].path_resolve(target.data_path, False)):
                target.id = own[target.id]
    return True


def own_action(id_block):
    """The action of a datablock, one of this file that no other uses; made if there is none. @throws SceneError."""
    _require_own(id_block)
    animation = id_block.animation_data
    action = animation.action if animation else None
    if action is None:
        return bpy.data.actions.new(id_block.name)
    if action.library is not None or compat.is_shared(animation):
        return action.copy()
    return action


def insert_key(owner, path, **options):
    """As `owner.keyframe_insert(path)`; what is linked gets a copy of its action in this file. @throws SceneError."""
    id_block = owner.id_data
    _require_own(id_block)
    animation = id_block.animation_data
    if animation is not None and animation.action is not None and animation.action.library is not None:
        compat.curves_to_write(id_block, animation.action.copy())
    try:
        owner.keyframe_insert(path, **options)
    except (RuntimeError, TypeError) as error:  # a locked curve
        raise SceneError(f"'{owner.name}' takes no keyframes on {path}: {error}") from error


def rotation_path(mover):
    """What Blender calls the rotation of an object or a pose bone, by its mode."""
    return {'QUATERNION': "rotation_quaternion", 'AXIS_ANGLE': "rotation_axis_angle"}.get(
        mover.rotation_mode, "rotation_euler"
    )


def _require_own(id_block):
    """@throws SceneError if keyframes would be gone when the file is opened again."""
    if id_block.library is not None:
        raise SceneError(f"'{id_block.name}' is linked, so its keyframes would not be saved. Make it local")


def is_animated(id_block):
    """Whether keyframes, strips or drivers move anything of a datablock."""
    animation = id_block.animation_data
    return animation is not None and bool(animation.action or animation.nla_tracks or animation.drivers)


def remove_action(id_block):
    """Takes the action off a datablock, and deletes it if nothing else needs it."""
    animation = id_block.animation_data
    action = animation.action if animation else None
    if action is None or compat.has_slots_of_others(animation):  # an empty slot is there for the next keyframes
        return
    animation.action = None
    with contextlib.suppress(ReferenceError):
        if action.users == 0:
            bpy.data.actions.remove(action)
