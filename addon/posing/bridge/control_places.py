# SPDX-License-Identifier: GPL-3.0-or-later
"""Where controls are, and where they are put back to: in the object's space as seen, and in that of the shape key.

A *place* is a 4 x 4 matrix in one of the two (scene/core/seen_space.py). A *rig transform* takes the second to the
first, for the vertices of one handle; it is motion.IDENTITY without a rig. Controls that Add Handle made have it in
their parent inverse: so they stand where the handle is seen, and their channels say where they are in the key's space
(docs/decisions/0020-posing-on-rigs.md).
"""

import bpy
import numpy as np
from mathutils import Matrix

from ...scene import rig_space, subject
from ...scene.core import motion
from . import members

#: A bone that deforms its own handle by half has moved it by half of what is missing each time that it is put back, and
#: what is put back takes its children along.
MOST_RESETS = 24

#: Of how far it was, what is put back gets no nearer if it is farther than that: then nothing moves it.
NEARER = 0.99


def at_rest(handle):
    """4 x 4: the control with its handle in the rest shape, in the key's space."""
    return np.array(handle.rest_relation, np.float64).reshape(4, 4)


def place_in_key(obj, handle, rig_transform):
    """4 x 4: the control of `handle` in the key's space, with the rig transform of now. @throws SceneError."""
    place, is_in_key = placement(obj, handle)
    return place if is_in_key or rig_transform is motion.IDENTITY else np.linalg.inv(rig_transform) @ place


def move(obj, handle, rig_transform=motion.IDENTITY):
    """4 x 4: how the control has moved its handle from the rest shape, in the key's space. @throws SceneError."""
    return motion.between(at_rest(handle), place_in_key(obj, handle, rig_transform))


def placement(obj, handle):
    """(4 x 4, whether that is in the key's space). What follows the rig has its place there, as if the rig were at
    rest; all else has it where it is seen. @throws SceneError."""
    place = np.linalg.inv(subject.to_world(obj)) @ world_of(handle)
    if not follows_rig(obj, handle):
        return place, False
    depsgraph, control = bpy.context.view_layer.depsgraph, handle.control
    parent_inverse = _parent_inverse(control if depsgraph is None else control.evaluated_get(depsgraph))
    if not np.array_equal(parent_inverse, motion.IDENTITY):
        place = motion.affine(frame_of(handle)) @ np.linalg.inv(parent_inverse) @ place
    return place, True


def follow_rig(obj, handle, rig_transform):
    """Puts the control, if it is one that Add Handle made, to where the rig has its handle; it keeps its channels."""
    wanted = rig_transform @ motion.affine(frame_of(handle))
    if follows_rig(obj, handle) and not motion.same(_parent_inverse(handle.control), wanted):
        handle.control.matrix_parent_inverse = Matrix(wanted)
        handle.control_carried = _parent_inverse(handle.control).ravel()


def rig_transforms(obj, handles):
    """[4 x 4]: what the rig does to each of `handles` now, measured."""
    space = rig_space.measure(obj)
    return [rig_transform(space, *each) for each in zip(handles, members.of(obj, handles), strict=True)]


def rig_transform(space, handle, vertices):
    """4 x 4: what the rig does to `handle`, which has `vertices`; space: SeenSpace or None."""
    if space is None or len(vertices) == 0:
        return motion.IDENTITY
    return space.transform_of(vertices, frame_of(handle) if follows_rig(handle.id_data, handle) else None)


def follows_rig(obj, handle):
    """Whether the control of `handle` goes along with the rig: Add Handle made it, and nobody has put it elsewhere."""
    control = handle.control
    if not (handle.made_control and control is not None and control.parent == obj and control.parent_type == 'OBJECT'):
        return False
    return motion.same(_parent_inverse(control), np.array(handle.control_carried, np.float64).reshape(4, 4))


def _parent_inverse(control):
    """4 x 4: what takes the control's channels to the object's space."""
    return np.array(control.matrix_parent_inverse, np.float64)


def frame_of(handle):
    """3 x 3: takes the control's own space, in which the world shows no shear, to the object's."""
    return np.array(handle.control_frame, np.float64).reshape(3, 3)


def unscaled(obj):
    """3 x 3: takes the object's uneven scale out, so that what turns in it turns in the world; the identity if even."""
    world = np.array(obj.matrix_world, np.float64)[:3, :3]
    _, sizes, axes = np.linalg.svd(world)
    if motion.is_flat(world) or np.ptp(sizes) <= 1e-5 * sizes.max():
        return np.eye(3)
    return axes.T @ np.diag(np.cbrt(sizes.prod()) / sizes) @ axes


def fitted(before, after, frame):
    """As motion.fitted(), rigid in the frame."""
    inverse = np.linalg.inv(frame)
    move = motion.fitted(before @ inverse.T, after @ inverse.T)
    return motion.affine(frame) @ move @ motion.affine(inverse)


def bone_of(handle):
    """The pose bone that moves a handle; None where its control is an object, or the bone is gone."""
    control = handle.control
    return control.pose.bones.get(handle.bone) if control.type == 'ARMATURE' else None


def world_of(handle):
    """4 x 4: the control, object or bone, in the world."""
    world, bone = np.array(handle.control.matrix_world, np.float64), bone_of(handle)
    return world if bone is None else world @ np.array(bone.matrix, np.float64)


def put(handle, world):
    """Puts the control to 4 x 4 `world`."""
    control, place, bone = handle.control, Matrix(world), bone_of(handle)
    if bone is None:
        control.matrix_world = place
    else:
        bone.matrix = control.matrix_world.inverted_safe() @ place


def reset(obj, handles):
    """Puts controls back to where their handles are in the rest shape. Returns the handles that are elsewhere still."""
    bpy.context.view_layer.update()
    for handle in handles:
        _renew_frame(obj, handle)
    away = np.inf
    for _ in range(MOST_RESETS + len(handles)):
        transforms, former = _follow_rig(obj, handles), away
        away = _away(obj, handles, transforms)
        if (away >= NEARER * former).all() or not away.any():
            break
        for handle, transform in zip(handles, transforms, strict=True):
            put(handle, np.array(obj.matrix_world) @ transform @ at_rest(handle))
            bpy.context.view_layer.update()  # the next may be a child of this one
    away = _away(obj, handles, _follow_rig(obj, handles))
    return [handle for handle, distance in zip(handles, away, strict=True) if distance != 0.0]


def _renew_frame(obj, handle):
    """Takes the uneven scale that the object has now out of where the control stands, as when it was made. Not of one
    with keyframes, whose channels would mean other places."""
    animation = handle.control.animation_data
    if not follows_rig(obj, handle) or (animation is not None and animation.action is not None):
        return
    frame, rest = unscaled(obj), at_rest(handle)
    rest[:3, :3] = frame @ np.linalg.inv(frame_of(handle)) @ rest[:3, :3]
    handle.control_frame, handle.rest_relation = frame.ravel(), rest.ravel()


def _follow_rig(obj, handles):
    """[4 x 4]: the transforms of now, which controls that go along with the rig have followed."""
    transforms = rig_transforms(obj, handles)
    for handle, transform in zip(handles, transforms, strict=True):
        follow_rig(obj, handle, transform)
    bpy.context.view_layer.update()
    return transforms


def _away(obj, handles, transforms):
    """How far each is from rest; 0 if it is there."""
    pairs = zip(handles, transforms, strict=True)
    return np.array([np.abs(move(obj, handle, transform) - motion.IDENTITY).max() for handle, transform in pairs])
