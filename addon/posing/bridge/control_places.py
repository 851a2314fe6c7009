# SPDX-License-Identifier: GPL-3.0-or-later
"""Where controls are: in the object's space as seen, and in the space of the shape key, where handles are at rest.

A *place* is a 4 x 4 matrix in one of the two (scene/core/seen_space.py). A *carry* takes the second to the first, for
the vertices of one handle; it is motion.IDENTITY without a rig. Controls that Add Handle made have the carry in their
parent inverse: so they stand where the handle is seen, and their channels say where they are in the key's space
(docs/decisions/0020-posing-on-rigs.md).
"""

import bpy
import numpy as np

from ...errors import SceneError
from ...scene import rig_space, vertex_groups
from ...scene.core import motion


def at_rest(group):
    """4 x 4: the control with its handle in the rest shape, in the key's space."""
    return np.array(group.rest_relation, np.float64).reshape(4, 4)


def place_in_key(obj, group, carry):
    """4 x 4: the control of `group` in the key's space; `carry` of its handle now. @throws SceneError."""
    return in_key(seat(obj, group), carry)


def in_key(seat, carry):
    """4 x 4 in the key's space, of a seat()."""
    place, goes_along = seat
    return place if goes_along or carry is motion.IDENTITY else np.linalg.inv(carry) @ place


def seat(obj, group):
    """(4 x 4, whether the rig carries the control along). What is carried along has its place in the key's space, as if
    the rig were at rest; all else has it where it is seen. @throws SceneError."""
    world = np.array(obj.matrix_world, np.float64)
    if is_flat(world):
        raise SceneError(f"'{obj.name}' is scaled to nothing. Give it a size")
    place = np.linalg.inv(world) @ world_of(group)
    if not goes_along(obj, group):
        return place, False
    carried = _carried(group)
    if carried is not None:
        place = to_4x4(frame_of(group)) @ np.linalg.inv(carried) @ place
    return place, True


def go_along(obj, group, carry):
    """Puts the control, if it is one that Add Handle made, to where the rig has carried its handle; it keeps its
    channels. Returns whether it was elsewhere."""
    if not goes_along(obj, group):
        return False
    wanted = carry @ to_4x4(frame_of(group))
    if motion.same(_parent_inverse(group.control), wanted):
        return False
    group.control.matrix_parent_inverse = to_blender(wanted)
    group.control_carried = _parent_inverse(group.control).ravel()
    return True


def carries(obj, groups):
    """[4 x 4]: the carry of the handle of each of `groups` now, measured."""
    space = rig_space.measure(obj)
    if space is None:
        return [motion.IDENTITY] * len(groups)
    members = vertex_groups.members(obj, [group.name for group in groups])
    return [carry(space, group, members.get(group.name, ())) for group in groups]


def carry(space, group, members):
    """4 x 4: the carry of the handle of `group`, whose vertex indices are `members`; space: SeenSpace or None."""
    if space is None or len(members) == 0:
        return motion.IDENTITY
    return space.carry(members, frame_of(group) if goes_along(group.id_data, group) else None)


def take_frame(group, frame):
    """Has the control of a handle at rest stand in another frame, turned as it was."""
    former = frame_of(group)
    if np.allclose(former, frame, rtol=0.0, atol=motion.NOISE):
        return
    rest = at_rest(group)
    left, _, right = np.linalg.svd(np.linalg.inv(former) @ rest[:3, :3])
    rest[:3, :3] = frame @ left @ right
    group.control_frame = frame.ravel()
    group.rest_relation = rest.ravel()


def goes_along(obj, group):
    """Whether the rig carries the control of `group` along: those that Add Handle made, where Blender's own ways have
    not put them elsewhere."""
    control = group.control
    if not (group.made_control and control is not None and control.parent == obj and control.parent_type == 'OBJECT'):
        return False
    return motion.same(_parent_inverse(control), np.array(group.control_carried, np.float64).reshape(4, 4))


def _carried(group):
    """4 x 4: what takes the control's channels to the object's space, as it was evaluated last; None for nothing."""
    depsgraph = bpy.context.view_layer.depsgraph
    carried = _parent_inverse(group.control if depsgraph is None else group.control.evaluated_get(depsgraph))
    return None if np.array_equal(carried, motion.IDENTITY) else carried


def _parent_inverse(control):
    return np.array(control.matrix_parent_inverse, np.float64)


def frame_of(group):
    """3 x 3: takes the control's own space, in which the world shows no shear, to the object's."""
    return np.array(group.control_frame, np.float64).reshape(3, 3)


def unscaled(obj):
    """3 x 3: what takes the object's uneven scale out, so that what is turned in it is turned in the world; the unit
    matrix where the scale is even."""
    world = np.array(obj.matrix_world, np.float64)[:3, :3]
    _, sizes, axes = np.linalg.svd(world)
    if is_flat(world) or np.ptp(sizes) <= 1e-5 * sizes.max():
        return np.eye(3)
    return axes.T @ np.diag(np.cbrt(sizes.prod()) / sizes) @ axes


def fitted(before, after, frame):
    """As motion.fitted(), rigid in the frame."""
    inverse = np.linalg.inv(frame)
    move = motion.fitted(before @ inverse.T, after @ inverse.T)
    return to_4x4(frame) @ move @ to_4x4(inverse)


def to_4x4(matrix):
    result = np.eye(4)
    result[:3, :3] = matrix
    return result


def world_of(group):
    """4 x 4: the control, object or bone, in the world."""
    control = group.control
    world = np.array(control.matrix_world, np.float64)
    if control.type == 'ARMATURE' and group.bone in control.pose.bones:
        world = world @ np.array(control.pose.bones[group.bone].matrix, np.float64)
    return world


def put(group, world):
    """Puts the control to 4 x 4 `world`."""
    control, place = group.control, to_blender(world)
    if control.type == 'ARMATURE' and group.bone in control.pose.bones:
        control.pose.bones[group.bone].matrix = control.matrix_world.inverted_safe() @ place
    else:
        control.matrix_world = place


def is_flat(matrix):
    """Whether a 4 x 4 matrix squeezes space, whatever its scale."""
    lengths = np.linalg.norm(matrix[:3, :3], axis=0)
    return not np.abs(np.linalg.det(matrix[:3, :3])) > 1e-9 * lengths.max(initial=0.0) ** 3


def to_blender(matrix):
    from mathutils import Matrix

    return Matrix(matrix.tolist())
