# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts the controls back to where their handles are in the rest shape."""

import bpy

from ... import wording
from ...live import engine
from ...widgets.base import MeshOperator
from ..bridge import control_places, controls


class MEANVALUE_OT_reset_handles(MeshOperator, bpy.types.Operator):
    """Put every control back to where its handle is in the rest shape. Controls moved by keyframes stay animated"""

    bl_idname = "meanvalue.reset_handles"
    bl_label = "Reset Handles"

    @classmethod
    def problem(cls, obj):
        return super().problem(obj) or controls.none_to_move(obj)

    def run(self, obj):
        controls.remove_deleted(obj)
        handles = [handle for handle in obj.meanvalue.handles if handle.follows == 'CONTROL']
        usable = [handle for handle in handles if controls.problem(obj, handle) is None]
        with engine.held():  # the mesh follows once, when all are where they belong
            held = [handle.name for handle in control_places.reset(obj, usable)]
        obj.update_tag()
        bpy.context.view_layer.update()
        notes = [controls.problem(obj, handle) for handle in handles if handle not in usable]
        if held:
            notes.append(
                f"{wording.quoted(held)} not at rest: something else moves the control, such as a posed parent or a "
                "constraint. Reset that too"
            )
        keyed = [
            handle.name for handle in usable if handle.control.animation_data and handle.control.animation_data.action
        ]
        if keyed:
            notes.append(f"The keyframes of {wording.quoted(keyed)} move the control again at the next change of frame")
        if not obj.meanvalue.live:
            notes.append("Live is off: press Solve to have the mesh follow")
        return f"{wording.counted(len(usable), 'handle')} reset", notes
