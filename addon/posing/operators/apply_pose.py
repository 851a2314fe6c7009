# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the pose the rest shape."""

import bpy

from ... import wording
from ...live import engine
from ...mixing.bridge import mix_layers
from ...scene import shape_keys, subject
from ..bridge import bound_record, controls, targets
from .settled import SettledOperator


class MEANVALUE_OT_apply_pose(SettledOperator, bpy.types.Operator):
    """Make the pose the new rest shape, to pose on from there. Other shape keys are carried along"""

    bl_idname = "meanvalue.apply_pose"
    bl_label = "Apply as Rest"

    def use(self, obj):
        handles = [handle for handle in obj.meanvalue.handles if handle.control is not None]
        placements = controls.placements(obj, handles)
        engine.look_again(obj)
        carried = shape_keys.apply_as_rest(obj, targets.pose_key(obj))
        bound_record.clear(obj.meanvalue.bound)
        controls.attach_at_rest(obj, handles, placements)
        notes = [subject.sharing_note(obj)] if subject.sharing_note(obj) else []
        carried, note = mix_layers.made_for_former_rest(obj, carried)
        notes += [note] if note else []
        if carried:
            keys = wording.counted(len(carried), "shape key")
            notes.append(f"{keys} carried along by what they add, and may look different: {wording.quoted(carried)}")
        return "The pose is the rest shape now. The mesh is bound again when it is posed", notes
