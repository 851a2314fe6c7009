# SPDX-License-Identifier: GPL-3.0-or-later
"""The soft handles of cuffs (core.capture.cuffs): one for each ring of vertices, whose control moves and turns."""

import numpy as np

from ...posing.bridge import control_places, controls
from ...scene import actions
from ...scene.core import motion
from . import marker_handles

COLOR = (0.0, 0.62, 0.45)
#: Radius of a control over that of the limb.
AROUND = 1.15


def update_handles(obj, matched):
    """Handles for the cuffs of a bridge.marker_matching.Matched, and for no other. What the artist set on the handle
    that a cuff has already is kept."""
    wanted = [_name(cuff) for cuff in matched.cuffs]
    handles = obj.meanvalue.handles
    for index in reversed(range(len(handles))):
        if handles[index].cuff and handles[index].made_control and handles[index].cuff not in wanted:
            controls.remove_handle(obj, index)
    for cuff in matched.cuffs:
        _update_handle(obj, cuff, matched)


def _name(cuff):
    return f"{cuff.segment} cuff"


def _update_handle(obj, cuff, matched):
    name = _name(cuff)
    handle = next((handle for handle in obj.meanvalue.handles if handle.cuff == name and handle.made_control), None)
    handle = handle or marker_handles.make_soft_handle(obj, name, COLOR)
    handle.cuff = name
    control = marker_handles.control_of(obj, handle, name, 'SPHERE', AROUND * cuff.radius)
    frame = control_places.unscaled(obj)  # in it a turn of the control is a turn in the world
    at_rest = control_places.to_4x4(frame)
    at_rest[:3, 3] = cuff.centre
    controls.choose(handle, control, at_rest)
    handle.control_frame, handle.control_carried = frame.ravel(), motion.IDENTITY.ravel()
    (rig,) = control_places.rig_transforms(obj, [handle])
    control_places.follow_rig(obj, handle, rig)
    marker_handles.give_members(obj, handle, cuff.vertices)
    _animate(control, cuff, matched.frames, np.linalg.inv(frame), np.array(obj.matrix_world, np.float64)[:3, :3])
    marker_handles.write_influence(control, ~np.isnan(cuff.centres[:, 0]), matched.frames, matched.ramp)


def _animate(control, cuff, frames, to_control, to_world):
    """Keys where the cuff goes; to_control, to_world  (3, 3) from the object's space."""
    present = ~np.isnan(cuff.centres[:, 0])
    places = cuff.centres[present] @ to_control.T
    basis = to_control @ np.linalg.inv(to_world)
    quaternions = _quaternions(basis @ cuff.turns[present] @ np.linalg.inv(basis))
    control.rotation_mode = 'QUATERNION'
    actions.write_vector(control, "location", frames[present], places)
    actions.write_vector(control, "rotation_quaternion", frames[present], quaternions)
    if present.any():
        control.location, control.rotation_quaternion = places[0], quaternions[0]


def _quaternions(turns):
    """(f, 4) of turns (f, 3, 3), each on the side of the one before: between keys the short way is taken."""
    from mathutils import Matrix

    result = np.array([Matrix(turn.tolist()).to_quaternion()[:] for turn in turns]).reshape(-1, 4)
    signs = np.where((result[1:] * result[:-1]).sum(axis=1) < 0.0, -1.0, 1.0)
    result[1:] *= np.cumprod(signs)[:, None]
    return result
