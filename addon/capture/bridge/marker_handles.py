# SPDX-License-Identifier: GPL-3.0-or-later
"""The soft handles that carry a mesh after the markers of a take, and their animated controls.

One vertex for each marker, and for each cuff (core.soles) some around a limb, whose control turns, too.
"""

import numpy as np
from mathutils import Matrix

from ...posing.bridge import control_places, controls, members
from ...scene import actions, worn
from ...scene.core import motion
from . import marker_pairs, takes

#: Size of a control, as a share of the mesh's bounding-box diagonal.
CONTROL_SIZE = 0.006

#: Of what was imported, once controls stand for it, over the mesh's size: it would hide the mesh.
IMPORTED_SIZE = 0.5 * CONTROL_SIZE

#: Radius of a cuff's control over that of the limb.
AROUND = 1.15

COLOR, CUFF_COLOR = (0.34, 0.71, 0.91), (0.0, 0.62, 0.45)

#: Motion capture is noisy, yet more to be trusted than the rest shape.
STRENGTH = 1.0


def update_handles(obj, matched):
    """Handles for every marker and cuff that was matched (bridge.marker_matching.Matched), and for no other."""
    capture = obj.meanvalue.capture
    for pair in capture.pairs:
        if pair.name not in matched.names:
            drop(obj, pair)
            if not pair.is_picked:
                pair.vertex = -1
            pair.distance = -1.0
    marker_pairs.list_markers(capture)
    if not obj.meanvalue.handles and not obj.meanvalue.along:
        worn.find(obj)
    for empty in takes.markers(capture.take):
        if empty.library is None:
            empty.empty_display_size = min(empty.empty_display_size, IMPORTED_SIZE * matched.world_size)
    capture.alignment = matched.alignment.ravel()
    capture.mesh_size = matched.size
    capture.reference_frame = matched.frame
    for number in range(len(matched.names)):
        update_handle(obj, matched, number)
    handles, cuffs = obj.meanvalue.handles, {f"{cuff.segment} cuff": cuff for cuff in matched.cuffs}
    for index in reversed(range(len(handles))):
        if handles[index].cuff and handles[index].made_control and handles[index].cuff not in cuffs:
            controls.remove_handle(obj, index)
    for name, cuff in cuffs.items():
        handle = next((handle for handle in obj.meanvalue.handles if handle.cuff == name and handle.made_control), None)
        handle = handle or _make_soft_handle(obj, name, CUFF_COLOR, cuff.strength)
        handle.cuff = name
        control = _control_of(obj, handle, name, 'SPHERE', AROUND * cuff.radius)
        frame = control_places.unscaled(obj)  # in it a turn of the control is a turn in the world
        controls.choose(handle, control, motion.affine(frame, cuff.centre))
        handle.control_frame, handle.control_carried = frame.ravel(), motion.IDENTITY.ravel()
        (rig,) = control_places.rig_transforms(obj, [handle])
        control_places.follow_rig(obj, handle, rig)
        members.give(obj, handle, cuff.vertices)
        to_control = np.linalg.inv(frame)
        basis = to_control @ np.linalg.inv(np.array(obj.matrix_world, np.float64)[:3, :3])
        turns = basis @ cuff.turns @ np.linalg.inv(basis)
        _animate(control, matched, cuff.centres @ to_control.T, to_control @ cuff.centre, turns)


def update_handle(obj, matched, number):
    """Has a handle move the vertex of a matched marker to its targets; where they are NaN, the handle is free.

    The handle that the marker has is used again, with what the artist set on it; else one is made.
    """
    name, vertex = matched.names[number], int(matched.vertices[number])
    pair = obj.meanvalue.capture.pairs[name]
    handle = marker_pairs.handle_of(obj, pair) or _make_soft_handle(obj, name, COLOR, STRENGTH)
    handle.marker = name
    control = _control_of(obj, handle, name, 'CUBE', CONTROL_SIZE * matched.size)
    controls.choose(handle, control, motion.affine(np.eye(3), matched.rest[number]))
    members.give(obj, handle, [vertex])
    pair.vertex = vertex
    pair.offset, pair.distance = matched.offsets[number], matched.distance[number]
    _animate(control, matched, matched.targets[:, number], matched.rest[number])


def drop(obj, pair):
    """Takes away what was made for a pair, which stays on the list."""
    index = marker_pairs.handle_index(obj, pair)
    if index is not None:
        controls.remove_handle(obj, index)


def _make_soft_handle(obj, name, color, strength):
    """A soft handle that follows a control, without vertices yet."""
    handle = obj.meanvalue.handles.add()
    members.make(obj, handle, name, [])
    handle.color = color
    handle.follows = 'CONTROL'
    handle.is_soft = True
    handle.strength = strength
    return handle


def _control_of(obj, handle, name, shape, size):
    """The control of a handle, or a new one: the first, or for one that was deleted or is the original's."""
    control = handle.control
    if control is not None and controls.owner_of(control) == obj:
        if not control.users_collection:
            controls.put_beside(obj, control)
        return control
    return controls.new_control(obj, handle, name, shape, size)


def _animate(control, matched, places, rest, turns=None):
    """Keys where the control goes: places (f, 3), turns (f, 3, 3) or None; rest (3,) is for a take without any."""
    control.location, present = rest, ~np.isnan(places).any(axis=1)
    takes.animate(control, places, matched.frames, matched.ramp)
    if turns is not None and present.any():
        quaternions = np.array([Matrix(turn.tolist()).to_quaternion()[:] for turn in turns[present]])
        signs = np.where((quaternions[1:] * quaternions[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
        quaternions[1:] *= np.cumprod(signs)[:, None]  # between keys the short way is taken
        control.rotation_mode = 'QUATERNION'
        actions.write_vector(control, "rotation_quaternion", matched.frames[present], quaternions)
        control.rotation_quaternion = quaternions[0]
