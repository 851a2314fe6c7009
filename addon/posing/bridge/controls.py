# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls: the objects and bones that move handles. Where they are is in control_places.py."""

import bpy
import numpy as np
from mathutils import Color, Matrix

from ... import compat, ids, wording
from ...errors import require_none
from ...scene import pose_objects, rig_space, shape_keys, subject, vertex_groups, views
from ...scene.core import motion
from . import control_places, members, orphans, region

NO_HANDLES = "There are no handles yet. Press on the mesh with Grab, or select vertices and press Add Handle"

#: A control is this much of the part that it moves: it is seen and clicked, and hides little of what it poses.
SIZE_OVER_PART = 0.8

#: Sizes of controls, as shares of the mesh's bounding-box diagonal: for a single vertex, and for a part that is long.
SMALLEST_SIZE = 0.008
LARGEST_SIZE = 0.1


def problem(obj, handle):
    """Why the control of `handle` cannot be followed, in words, or None. A pin has none."""
    if handle.follows == 'REST':
        return None
    missing = why_it_is_missing(obj, handle)
    if missing is not None:
        return missing
    control = handle.control
    if control.type == 'ARMATURE' and handle.bone and handle.bone not in control.pose.bones:
        return f"'{control.name}' has no bone '{handle.bone}', which moves handle '{handle.name}'. Choose another bone"
    if motion.is_flat(control_places.at_rest(handle)):
        return f"The control of handle '{handle.name}' was scaled to nothing. Choose it again once it has a size"
    if _hangs_on(control, obj):
        return f"The control of '{handle.name}' hangs on vertices of '{obj.name}' itself. Parent it to the object"
    return None


def why_it_is_missing(obj, handle):
    """Why Update has to make a control for `handle`, or to put it back, in words, or None."""
    control = handle.control
    if control is None:
        return f"Handle '{handle.name}' has no control. Press Update, choose one, or remove the handle"
    is_there = control.visible_get() or bpy.context.view_layer.objects.get(control.name) == control
    if not is_there and not control.users_collection:  # Blender goes through all objects of the file for that
        return f"The control of handle '{handle.name}' is in no collection. Press Update, or choose another one"
    owner = obj if control.parent == obj else owner_of(control)
    if owner not in {None, obj}:
        return f"The control of handle '{handle.name}' belongs to '{owner.name}'. Press Update to have another one"
    return None


def stillness(obj, handles):
    """Why any of the handles stays where it is, whatever moves its control, in words, or None."""
    rig = rig_space.armature(obj)  # evaluated for the mesh, wherever it is
    still = [each.name for each in handles if each.control != rig and not views.is_evaluated(each.control)]
    if not still or not views.is_evaluated(obj):
        return None
    return f"Blender moves no control that is disabled or excluded: {wording.quoted(still)}. {views.ENABLE}"


def none_to_move(obj):
    """Why there is no control to move, in words, or None."""
    return None if any(handle.follows == 'CONTROL' for handle in obj.meanvalue.handles) else NO_HANDLES


def none_active(obj):
    """Why there is no active handle or pin, in words, or None."""
    if obj.meanvalue.active_handle < len(obj.meanvalue.handles):
        return None
    return "There is no active handle or pin. Press on the mesh with Grab, press Add Handle, or click one in the list"


def remove_deleted(obj):
    """For operators: removes the handles whose control the artist has deleted. They are gone with it before, and back
    with it by undo, but what is written beside an operator's undo step would not be taken back."""
    for index in reversed(range(len(obj.meanvalue.handles))):
        if orphans.is_deleted(obj.meanvalue.handles[index]):
            region.let_go(obj, obj.meanvalue.handles[index])
            remove_handle(obj, index)


def owner_of(control):
    """The mesh object that a control made by Add Handle belongs to, or None. Such controls are its children."""
    parent = control.parent
    if parent is None or parent.type != 'MESH':
        return None
    return parent if any(handle.control == control for handle in parent.meanvalue.handles) else None


def require_places(obj, handles):
    """@throws SceneError for what attach_where_they_are() would fail of."""
    rig_space.measure(obj)
    for handle in handles:
        control_places.placement(obj, handle)


def attach_where_they_are(obj, handles, moves=None):
    """From here on the controls, where they are now, have moved their handles by `moves`, 4 x 4 as of shown_move();
    None: not at all. @throws SceneError."""
    transforms = control_places.rig_transforms(obj, handles)
    for handle, transform, move in zip(handles, transforms, moves or [motion.IDENTITY] * len(handles), strict=True):
        place = control_places.place_in_key(obj, handle, transform)
        handle.rest_relation = (np.linalg.inv(move) @ place).ravel()


def shown_move(obj, handle):
    """4 x 4: how the handle is moved from the rest shape where it is seen, in the key's space, whatever moves it."""
    (vertices,) = members.of(obj, [handle])
    shown = shape_keys.posed_positions(obj)
    if len(vertices) == 0 or shown is None:
        return motion.IDENTITY
    frame, space = control_places.frame_of(handle), rig_space.measure(obj)
    if space is None:
        move = control_places.fitted(shape_keys.rest_positions(obj.data)[vertices], shown[vertices], frame)
    else:
        transform = control_places.rig_transform(space, handle, vertices)
        with rig_space.evaluating(obj) as evaluate:
            seen = evaluate(shown)
        move = np.linalg.inv(transform) @ control_places.fitted(space.seen[vertices], seen[vertices], frame) @ transform
    return motion.between(motion.IDENTITY, move)


def paint(control, handle):
    """Gives a control its handle's color. Blender keeps an object's linear; a handle's is the one that is shown."""
    control.color = (*Color(handle.color).from_srgb_to_scene_linear(), 1.0)


def add_control(obj, handle, vertices, color=None):
    """Makes the Empty that moves `handle`, which has these vertices, where they are seen."""
    carried = sum(other.follows == 'CONTROL' for other in obj.meanvalue.handles)
    handle.color = color or views.COLORS[carried % len(views.COLORS)]
    rest_points = shape_keys.rest_positions(obj.data)[vertices]
    whole, extent = region.shown_size(obj), np.ptp(rest_points, axis=0).max()
    size = float(np.clip(SIZE_OVER_PART * 0.5 * extent, SMALLEST_SIZE * whole, LARGEST_SIZE * whole))
    control = new_control(obj, handle, handle.name, 'CUBE', size)
    choose(handle, control, motion.IDENTITY)
    handle.follows = 'CONTROL'
    frame = control_places.unscaled(obj)
    handle.control_frame, handle.control_carried = frame.ravel(), motion.IDENTITY.ravel()
    move_now = shown_move(obj, handle)
    middle = motion.apply(move_now, rest_points.mean(axis=0, dtype=np.float64))
    place = motion.affine(move_now[:3, :3] @ frame, middle)
    handle.rest_relation = (np.linalg.inv(move_now) @ place).ravel()
    control.matrix_basis = Matrix(np.linalg.inv(motion.affine(frame)) @ place)
    (transform,) = control_places.rig_transforms(obj, [handle])
    control_places.follow_rig(obj, handle, transform)
    return control


def new_control(obj, handle, name, shape, size):
    """An Empty for a handle, a child of the object: moving the object moves both and poses nothing."""
    control = bpy.data.objects.new(f"{obj.name} {name}", None)
    control.empty_display_type, control.empty_display_size, control.show_in_front = shape, size, True
    paint(control, handle)
    control.parent = obj
    put_beside(obj, control)
    return control


def put_beside(obj, control):
    """Puts a control into collections for controls beside the object, which exports can leave out."""
    homes = [each for each in obj.users_collection if each.library is None and each.override_library is None]
    homes = homes or [bpy.context.scene.collection]
    for home in {_place_for_controls(each) for each in homes}:
        home.objects.link(control)
    orphans.made(control, obj)
    views.show_in_local_views(control, obj)
    if pose_objects.shown(obj).visible_get() and not control.visible_get():  # the others were put out of sight
        for home in homes:
            home.objects.link(control)


def _place_for_controls(collection):
    for each in (collection, *collection.children):
        if ids.CONTROLS_MARK in each and each.library is None:
            return each
    made = bpy.data.collections.new(ids.CONTROLS_COLLECTION)
    made[ids.CONTROLS_MARK] = True
    collection.children.link(made)
    return made


def choose(handle, control, rest_relation, made=True):
    """Sets the control and where it is at rest (4 x 4). made: by the add-on, so that it goes with the handle."""
    handle.attached, handle.attached_bone = control, handle.bone
    handle.rest_relation = rest_relation.ravel()
    handle.control = control
    handle.made_control = made


def remove_control(handle):
    """Deletes the control, with its animation, if it was made for this object and no other handle follows it."""
    control = handle.control
    if control is None or not handle.made_control:
        return
    heirs = [other for other in handle.id_data.meanvalue.handles if other != handle and other.control == control]
    if heirs:
        heirs[0].made_control = True
    elif owner_of(control) == handle.id_data:
        for child in control.children:  # what the artist hung on it stays where it is
            world = child.matrix_world.copy()
            child.parent = None
            child.matrix_world = world
        orphans.delete(control)


def remove_handle(obj, index):
    """Removes a handle, with what was made for it: its control and its marks, or vertex group."""
    settings = obj.meanvalue
    handle = settings.handles[index]
    name, mark, made_group, control = handle.name, handle.mark, handle.made_group, handle.control
    if control is not None and bpy.context.view_layer.objects.active == control:
        subject.choose(obj)
    remove_control(handle)
    settings.handles.remove(index)
    members.tidy(obj, mark)
    if name == made_group and name not in settings.handles:
        vertex_groups.remove_made(obj, name)
    obj.update_tag()
    settings.active_handle = max(0, min(settings.active_handle, len(settings.handles) - 1))


def select(handle):
    """Makes the control the active object, and a bone the active one of its armature. @throws SceneError."""
    require_none(problem(handle.id_data, handle) or stillness(handle.id_data, [handle]))
    subject.choose(handle.control)
    bone = control_places.bone_of(handle)
    if bone is not None:
        handle.control.data.bones.active = bone.bone


def mover(handle):
    """The object or pose bone that moves a handle which has no problem()."""
    return control_places.bone_of(handle) or handle.control


def note_active(obj):
    """Makes the handle of the control `obj`, which the artist has just made active, the active one."""
    mesh_object = owner_of(obj)
    if mesh_object is None:
        return
    settings = mesh_object.meanvalue
    index = next(number for number, handle in enumerate(settings.handles) if handle.control == obj)
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


_known = {}  # session key of an object: name of the mesh object that follows it, or ""


def mesh_moved_by(control):
    """A mesh object of the scene with a handle that follows `control`, the one it belongs to first; or None."""
    owner = owner_of(control)
    if owner is not None:
        return owner
    key = compat.session_key(control)
    found = bpy.data.objects.get(_known.get(key, ""))
    if _known.get(key) != "" and not _follows(found, control):  # to find none takes going through all
        found = next((obj for obj in bpy.context.view_layer.objects if _follows(obj, control)), None)
        _known[key] = found.name if found is not None else ""
    return found


def _follows(obj, control):
    is_mesh = obj is not None and obj.type == 'MESH'
    return is_mesh and any(handle.control == control for handle in obj.meanvalue.handles)


def forget_moved_meshes():
    _known.clear()
