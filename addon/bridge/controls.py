# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls: the objects and bones that carry handles, and where they are relative to the mesh."""

import bpy
import numpy as np

from ..core import motion
from ..errors import SceneError
from . import selection

#: A control is this much larger than the part that it carries, so that it can be seen and clicked.
SIZE_OVER_PART = 1.25

#: Sizes of controls, as shares of the mesh's bounding-box diagonal: for a single vertex, and for a part that is long.
SMALLEST_SIZE = 0.02
LARGEST_SIZE = 0.15


def problem(obj, group):
    """Why the control of `group` cannot be followed, in words, or None."""
    control = group.control
    if control is None:
        return f"Handle '{group.name}' has no control. Choose an object or a bone for it, or remove the handle"
    if not control.users_scene:
        return f"The control of handle '{group.name}' was deleted. Choose another one for it, or remove the handle"
    owner = owner_of(control)
    if owner is not None and owner != obj:
        return (
            f"The control of handle '{group.name}' belongs to '{owner.name}'. Press Make Own Controls to give "
            f"'{obj.name}' controls of its own"
        )
    if control.type == 'ARMATURE' and group.bone and group.bone not in control.pose.bones:
        return f"'{control.name}' has no bone '{group.bone}', which carries handle '{group.name}'. Choose another bone"
    if abs(np.linalg.det(_relation_at_rest(group)[:3, :3])) < 1e-12:
        return f"The control of handle '{group.name}' was scaled to nothing. Choose it again once it has a size"
    return None


def owner_of(control):
    """The mesh object that a control made by Add Handle belongs to, or None. Such controls are its children."""
    parent = control.parent
    if parent is None or parent.type != 'MESH':
        return None
    return parent if any(group.control == control for group in parent.meanvalue.anchor_groups) else None


def carried_by(control):
    """A mesh object of the scene with a handle that follows `control`, the one it belongs to first; or None."""
    owner = owner_of(control)
    if owner is not None:
        return owner
    for obj in bpy.context.view_layer.objects:
        if obj.type == 'MESH' and any(group.control == control for group in obj.meanvalue.anchor_groups):
            return obj
    return None


def move(obj, group):
    """4 x 4: how the control has moved its handle from the rest shape, in the object's space. @throws SceneError."""
    return motion.between(_relation_at_rest(group), _relation(obj, group))


def take_hold(obj, group):
    """From here on the control is where it is with its handle in the rest shape."""
    if group.control is not None:
        _remember(group, _relation(obj, group))


def add_control(obj, group, rest_points, shown_points):
    """Makes the Empty that carries `group`, at its vertices, as they are shown (n x 3 both).

    It is a child of the object, so that moving the object moves both and poses nothing.
    """
    control = bpy.data.objects.new(f"{obj.name} {group.name}", None)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(control)
    move_now = motion.fitted(rest_points, shown_points)
    relation = np.eye(4)
    relation[:3, :3] = move_now[:3, :3]
    relation[:3, 3] = shown_points.mean(axis=0, dtype=np.float64)
    control.empty_display_type = 'CUBE'
    control.empty_display_size = _size(obj, shown_points)
    control.show_in_front = True
    control.color = (*group.color, 1.0)
    control.rotation_mode = 'QUATERNION'
    control.parent = obj
    control.matrix_basis = _to_blender(relation)
    group.follows = 'CONTROL'
    group.control = control
    group.made_control = True
    _remember(group, np.linalg.inv(move_now) @ relation)
    return control


def remove_control(group):
    """Deletes the control if Add Handle made it."""
    control = group.control
    if control is not None and group.made_control:
        bpy.data.objects.remove(control)


def select(group):
    """Makes the control the active object, and a bone the active one of its armature."""
    selection.choose(group.control)
    if group.control.type == 'ARMATURE' and group.bone in group.control.data.bones:
        group.control.data.bones.active = group.control.data.bones[group.bone]


def reset(obj, group):
    """Puts the control back to where its handle is in the rest shape."""
    target = obj.matrix_world @ _to_blender(_relation_at_rest(group))
    if group.control.type == 'ARMATURE' and group.bone:
        group.control.pose.bones[group.bone].matrix = group.control.matrix_world.inverted() @ target
    else:
        group.control.matrix_world = target


def _relation(obj, group):
    """4 x 4: the control in the object's space."""
    world = np.array(obj.matrix_world, np.float64)
    if abs(np.linalg.det(world)) < 1e-30:
        raise SceneError(f"'{obj.name}' is scaled to nothing. Give it a size")
    return np.linalg.inv(world) @ _control_world(group)


def _control_world(group):
    control = group.control
    world = np.array(control.matrix_world, np.float64)
    if control.type == 'ARMATURE' and group.bone in control.pose.bones:
        world = world @ np.array(control.pose.bones[group.bone].matrix, np.float64)
    return world


def _relation_at_rest(group):
    return np.array(group.rest_relation, np.float64).reshape(4, 4)


def _remember(group, relation):
    group.rest_relation = relation.ravel()


def _size(obj, points):
    extent = np.ptp(points, axis=0)
    whole = float(np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0)))
    return float(np.clip(SIZE_OVER_PART * 0.5 * extent.max(), SMALLEST_SIZE * whole, LARGEST_SIZE * whole))


def _to_blender(matrix):
    from mathutils import Matrix

    return Matrix(matrix.tolist())
