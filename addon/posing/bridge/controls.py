# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls: the objects and bones that carry handles. Where they are is in control_places.py."""

import bpy
import numpy as np
from mathutils import Color

from ... import compat
from ...errors import SceneError
from ...scene import actions, rig_space, selection, shape_keys, vertex_groups, views
from ...scene.core import motion
from . import control_places

#: Whether choose() is at work: the update of the property then leaves the place at rest alone.
is_choosing = False

#: A control is this much larger than the part that it carries, so that it can be seen and clicked.
SIZE_OVER_PART = 1.25

#: Sizes of controls, as shares of the mesh's bounding-box diagonal: for a single vertex, and for a part that is long.
SMALLEST_SIZE = 0.02
LARGEST_SIZE = 0.15


def problem(obj, group):
    """Why the control of `group` cannot be followed, in words, or None."""
    control = group.control
    if control is None:
        return (
            f"Handle '{group.name}' has no control. Press Make Own Controls, choose an object or a bone for it, or "
            "remove the handle"
        )
    if not _is_in_a_scene(control):
        return (
            f"The control of handle '{group.name}' was deleted. Press Make Own Controls, choose another one for it, or "
            "remove the handle"
        )
    owner = owner_of(control)
    if owner is not None and owner != obj:
        return (
            f"The control of handle '{group.name}' belongs to '{owner.name}'. Press Make Own Controls to give "
            f"'{obj.name}' controls of its own"
        )
    if control.type == 'ARMATURE' and group.bone and group.bone not in control.pose.bones:
        return f"'{control.name}' has no bone '{group.bone}', which carries handle '{group.name}'. Choose another bone"
    if control_places.is_flat(control_places.at_rest(group)):
        return f"The control of handle '{group.name}' was scaled to nothing. Choose it again once it has a size"
    if _hangs_on(control, obj):
        return (
            f"The control of handle '{group.name}' hangs on vertices of '{obj.name}' itself, so it would move with "
            "what it moves. Parent it to the object instead, or remove the constraint"
        )
    return None


def _is_in_a_scene(control):
    """As `control.users_scene`, which goes through all objects of the file."""
    return bpy.context.view_layer.objects.get(control.name) == control or bool(control.users_scene)


def owner_of(control):
    """The mesh object that a control made by Add Handle belongs to, or None. Such controls are its children."""
    parent = control.parent
    if parent is None or parent.type != 'MESH':
        return None
    return parent if any(group.control == control for group in parent.meanvalue.handles) else None


def carried_by(control):
    """A mesh object of the scene with a handle that follows `control`, the one it belongs to first; or None."""
    owner = owner_of(control)
    if owner is not None:
        return owner
    for obj in bpy.context.view_layer.objects:
        if obj.type == 'MESH' and any(group.control == control for group in obj.meanvalue.handles):
            return obj
    return None


def move(obj, group, carry=motion.IDENTITY):
    """4 x 4: how the control has moved its handle from the rest shape, in the key's space. @throws SceneError."""
    return motion.between(control_places.at_rest(group), control_places.place_in_key(obj, group, carry))


def take_hold(group, place):
    """From here on the control is at `place` (4 x 4, in the key's space) with its handle in the rest shape."""
    group.rest_relation = place.ravel()


def hold_as_shown(obj, group, shown):
    """From here on the control carries the handle from where both are now; `shown` is its shown_move().

    @throws SceneError.
    """
    (carry,) = control_places.carries(obj, [group])
    place = control_places.place_in_key(obj, group, carry)
    take_hold(group, np.linalg.inv(shown) @ place)


def seats(obj, groups):
    """Where the controls are, for hold_at_rest(). @throws SceneError, also for what that would fail of."""
    rig_space.measure(obj)
    return [control_places.seat(obj, group) for group in groups]


def hold_at_rest(obj, groups, seats):
    """From here on the controls carry their handles in the rest shape from `seats`, where they are."""
    for group, seat, carry in zip(groups, seats, control_places.carries(obj, groups), strict=True):
        take_hold(group, control_places.in_key(seat, carry))


def shown_move(obj, group):
    """4 x 4: how the handle is moved from the rest shape where it is seen, in the key's space, whatever carries it."""
    members = vertex_groups.members(obj, [group.name]).get(group.name)
    shown = shape_keys.result_positions(obj)
    if members is None or len(members) == 0 or shown is None:
        return np.eye(4)
    frame, space = control_places.frame_of(group), rig_space.measure(obj)
    if space is None:
        move = control_places.fitted(shape_keys.rest_positions(obj.data)[members], shown[members], frame)
    else:
        carry = control_places.carry(space, group, members)
        seen = rig_space.seen(obj, space, shown)
        move = np.linalg.inv(carry) @ control_places.fitted(space.seen[members], seen[members], frame) @ carry
    return motion.between(np.eye(4), move)


def paint(control, group):
    """Gives a control its handle's colour. Blender keeps an object's linear; a handle's is the one that is shown."""
    control.color = (*Color(group.color).from_srgb_to_scene_linear(), 1.0)


def add_control(obj, group, rest_points, shown_points):
    """Makes the Empty that carries `group`, at its vertices, as its key shows them (n x 3 both), where they are seen.

    It is a child of the object, so that moving the object moves both and poses nothing.
    """
    control = bpy.data.objects.new(f"{obj.name} {group.name}", None)
    for collection in obj.users_collection or (bpy.context.scene.collection,):
        collection.objects.link(control)
    views.show_in_local_views(control, obj)
    control.empty_display_type = 'CUBE'
    control.empty_display_size = _size(obj, shown_points)
    control.show_in_front = True
    paint(control, group)
    control.parent = obj
    choose(group, control, motion.IDENTITY)
    group.follows = 'CONTROL'
    group.made_control = True
    frame = control_places.unscaled(obj)
    group.control_frame, group.control_carried = frame.ravel(), motion.IDENTITY.ravel()
    if rig_space.is_there(obj):
        move_now = shown_move(obj, group)
    else:
        move_now = control_places.fitted(rest_points, shown_points, frame)
    place = np.eye(4)
    place[:3, :3] = move_now[:3, :3] @ frame
    place[:3, 3] = motion.apply(move_now, rest_points.mean(axis=0, dtype=np.float64))
    take_hold(group, np.linalg.inv(move_now) @ place)
    control.matrix_basis = control_places.to_blender(np.linalg.inv(control_places.to_4x4(frame)) @ place)
    (carry,) = control_places.carries(obj, [group])
    control_places.go_along(obj, group, carry)
    return control


def choose(group, control, rest_relation):
    """Sets the control and where it is at rest (4 x 4) together: nothing may be posed by one without the other."""
    global is_choosing
    is_choosing = True
    try:
        group.control = control
    finally:
        is_choosing = False
    take_hold(group, rest_relation)


def remove_control(group):
    """Deletes the control, with its animation, if it was made for this object. Another line that follows it gets it."""
    control = group.control
    if control is None or not group.made_control:
        return
    heirs = [line for line in group.id_data.meanvalue.handles if line != group and line.control == control]
    if heirs:
        heirs[0].made_control = True
    elif owner_of(control) == group.id_data:
        for child in control.children:  # what the artist hung on it stays where it is
            world = child.matrix_world.copy()
            child.parent = None
            child.matrix_world = world
        actions.remove_action(control)
        bpy.data.objects.remove(control)


def remove_handle(obj, index):
    """Takes a line off the list of handles, with the control and vertex group that were made for it.

    Returns whether the vertex group was deleted.
    """
    settings = obj.meanvalue
    line = settings.handles[index]
    name, made_group, control = line.name, line.made_group, line.control
    if control is not None and bpy.context.view_layer.objects.active == control:
        selection.choose(obj)
    remove_control(line)
    settings.handles.remove(index)
    was_deleted = made_group and vertex_groups.remove_made(obj, name)
    obj.update_tag()
    settings.active_handle = max(0, min(settings.active_handle, len(settings.handles) - 1))
    return was_deleted


def select(group):
    """Makes the control the active object, and a bone the active one of its armature. @throws SceneError."""
    if group.control.name not in bpy.context.view_layer.objects:
        raise SceneError(
            f"The control of '{group.name}' is in a collection that this view layer leaves out. Tick the collection "
            "in the Outliner"
        )
    selection.choose(group.control)
    if group.control.type == 'ARMATURE' and group.bone in group.control.data.bones:
        group.control.data.bones.active = group.control.data.bones[group.bone]


def mover(group):
    """The object or pose bone that carries a handle which has no problem()."""
    control = group.control
    bone = control.pose.bones.get(group.bone) if control.type == 'ARMATURE' else None
    return control if bone is None else bone


def is_selected(group):
    """Whether the artist has selected what carries the handle; a bone counts in Pose Mode, with its armature else."""
    carrier = mover(group)
    if isinstance(carrier, bpy.types.PoseBone) and group.control.mode == 'POSE':
        return compat.is_bone_selected(carrier)
    return group.control.select_get()


def note_active(obj):
    """Makes the line of the control `obj`, which the artist has just made active, the active one of the list."""
    mesh_object = owner_of(obj)
    if mesh_object is None:
        return
    settings = mesh_object.meanvalue
    index = next(number for number, group in enumerate(settings.handles) if group.control == obj)
    if settings.active_handle != index:
        settings.active_handle = index


def _hangs_on(control, obj):
    """Whether an object, or one that it is parented to, follows vertices of `obj`."""
    while control is not None:
        if control.parent == obj and control.parent_type in {'VERTEX', 'VERTEX_3'}:
            return True
        if any(getattr(each, "target", None) == obj and getattr(each, "subtarget", "") for each in control.constraints):
            return True
        control = control.parent
    return False


def _size(obj, points):
    extent = np.ptp(points, axis=0)
    whole = float(np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0)))
    return float(np.clip(SIZE_OVER_PART * 0.5 * extent.max(), SMALLEST_SIZE * whole, LARGEST_SIZE * whole))
