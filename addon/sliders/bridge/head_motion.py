# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of the whole head as keys of location and rotation, of the object or of a bone of its armature.

What carries the head has a transform of its own, which becomes `left @ motion @ right` where the head moves by a motion
in the object's space: a pair of matrices.
"""

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import actions, rig_space

#: What becomes of the motion of the whole.
ON_OBJECT, ON_BONE, DROPPED, STILL = 'OBJECT', 'BONE', 'DROPPED', 'STILL'

#: How unequal the scales of an object may be.
EVEN = 1e-3


def require_room(obj, options):
    """@throws SceneError if what carries the head can't take the motion, or would lose its own."""
    if options.head_motion not in (ON_OBJECT, ON_BONE):
        return
    scales = np.abs(obj.scale)
    if scales.min() < (1.0 - EVEN) * scales.max():
        raise SceneError(
            f"'{obj.name}' is scaled unevenly, so it can't turn as the head does. Apply the scale (Ctrl A), or choose "
            "another Head Motion"
        )
    owner, carrier = _carrier(obj, options)
    names = [
        name
        for name, path in zip(("location", "rotation"), actions.motion_paths(carrier), strict=True)
        if any(len(actions.read_keys(owner, path, index)[0]) for index in range(3))
    ]
    if names and not options.replace:
        raise SceneError(
            f"The {wording.listed(names)} of '{carrier.name}' is animated already. Turn on Replace to write over that, "
            "or choose another Head Motion"
        )


def pair(obj, options):
    """(2, 4, 4) float64: the matrices left and right of the motion, as things are now. @throws SceneError."""
    owner, carrier = _carrier(obj, options)
    own = np.array(carrier.matrix_basis, np.float64)
    if owner == carrier:
        return np.array([own, np.eye(4)])
    # Weights carry the mesh from where the bone is at rest, a parent from where it is posed.
    start = carrier.matrix if obj.parent_type == 'BONE' else carrier.bone.matrix_local
    bone = np.array(obj.matrix_world.inverted_safe() @ owner.matrix_world @ start, np.float64)
    return np.array([own @ np.linalg.inv(bone), bone])


def write(obj, options, frames, pairs, motions):
    """Keys at `frames` (f,): pairs (f, 2, 4, 4), and the rigid motions of the head (f, 4, 4). Returns notes."""
    owner, carrier = _carrier(obj, options)
    actions.write_motion(carrier, frames, pairs[:, 0] @ motions @ pairs[:, 1])
    if owner != carrier and carrier.bone.use_connect:
        return [f"Bone '{carrier.name}' is connected to its parent, so it turns as the head does and stays in place"]
    return []


def _carrier(obj, options):
    """(what is keyed, what has location and rotation): the object, or its armature and a bone. @throws SceneError."""
    if options.head_motion != ON_BONE:
        return obj, obj
    rig = rig_space.armature(obj)
    if rig is None:
        raise SceneError(f"'{obj.name}' follows no armature, so no bone moves it. Choose another Head Motion")
    if rig.library is not None or rig.override_library is not None:
        raise SceneError(f"'{rig.name}' is linked from another file. Make it local, or choose another Head Motion")
    bone = rig.pose.bones.get(options.bone)
    if bone is None:
        raise SceneError(f"'{rig.name}' has no bone '{options.bone}'. Choose the bone of the head in Bone")
    return rig, bone
