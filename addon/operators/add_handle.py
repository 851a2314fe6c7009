# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes handles and pins of selected vertices or of vertex groups."""

import bpy
import numpy as np

from .. import ids
from ..bridge import handle_lines, scene_input, selection, shape_keys, vertex_groups
from ..core import wording
from ..core.bind_input import require_finite
from ..errors import SceneError
from .base import MeshOperator


class NewAnchors(MeshOperator):
    """Mix-in: anchors from the vertices selected in Edit Mode, or from a vertex group in Object Mode."""

    needs_object_mode = False
    new_group_name = ""

    group: bpy.props.StringProperty(
        name="Vertex Group",
        description="Vertex group to use. If empty: the selected vertices in Edit Mode, the active group else",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    name: bpy.props.StringProperty(
        name="Name",
        description="Name of the vertex group that is made of selected vertices",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    # Adjusting the operator runs it again in Object Mode, where the vertices are still selected.
    from_selection: bpy.props.BoolProperty(options={'HIDDEN', 'SKIP_SAVE'})

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and obj.mode not in {'EDIT', 'OBJECT'}:
            problem = f"{scene_input.mode_problem(obj)}, or to Edit Mode"
        return problem

    def run(self, obj):
        is_editing = obj.mode == 'EDIT'
        if is_editing:
            obj.update_from_editmode()
        self.from_selection = self.from_selection or (is_editing and not self.group)
        name, members = self._members(obj)
        self.require_usable(obj, members)
        selection.leave_edit_mode(obj)
        line = handle_lines.add_line(obj, members, group=name, new_name=self.name or self.new_group_name)
        message = self.equip(obj, line, members)
        try:
            scene_input.gather(obj)
        except SceneError as problem:  # there is more to do before it can be posed
            return message, [str(problem)]
        return message, []

    def require_usable(self, obj, members):
        """@throws SceneError before anything is changed."""

    def _members(self, obj):
        """(name of the vertex group or "" for a new one, vertex indices). @throws SceneError."""
        name = self.group
        if self.from_selection:
            members = selection.selected_vertices(obj)
            if len(members) == 0:
                raise SceneError("No vertices are selected. Select the ones to hold, then press the button again")
            return "", members
        active = obj.vertex_groups.active
        name = name or (active.name if active else "")
        if not name:
            raise SceneError(
                "There is nothing to take: select vertices in Edit Mode, or choose a vertex group to use as it is"
            )
        vertex_groups.require(obj, name, "to be used", "Choose one that it has")
        if name in obj.meanvalue.anchor_groups:
            raise SceneError(
                f"Vertex group '{name}' is on the list already. Select vertices in Edit Mode, or choose another group"
            )
        members = vertex_groups.members(obj, [name])[name]
        if len(members) == 0:
            raise SceneError(f"Vertex group '{name}' has no vertices with a weight above zero. Assign some first")
        return name, members


class MEANVALUE_OT_add_handle(NewAnchors, bpy.types.Operator):
    """Make a handle of the selected vertices (Edit Mode) or the active vertex group, with a control to drag"""

    bl_idname = "meanvalue.add_handle"
    bl_label = "Add Handle"
    new_group_name = ids.HANDLE_GROUP

    live: bpy.props.BoolProperty(
        name="Live", description="Turn Live on with the first handle", default=True, options={'SKIP_SAVE'}
    )

    def run(self, obj):
        self._was_first = all(group.follows != 'CONTROL' for group in obj.meanvalue.anchor_groups)
        return super().run(obj)

    def require_usable(self, obj, members):
        require_finite(shape_keys.rest_positions(obj.data)[members], "handle in the rest shape")
        shown = shape_keys.result_positions(obj)
        if shown is not None:
            require_finite(shown[members], f"handle in shape key '{obj.meanvalue.result_key}'")

    def equip(self, obj, line, members):
        control = handle_lines.make_handle(obj, line, members)
        if self.live and self._was_first and not obj.meanvalue.live:
            obj.meanvalue.live = True
        selection.choose(control)
        count = wording.vertices(len(np.unique(members)))
        return f"Handle '{line.name}' carries {count}: move, turn or scale its control"


class MEANVALUE_OT_add_pin(NewAnchors, bpy.types.Operator):
    """Pin the selected vertices (Edit Mode) or the active vertex group: they stay where they are at rest"""

    bl_idname = "meanvalue.add_pin"
    bl_label = "Add Pin"
    new_group_name = ids.PIN_GROUP

    def equip(self, _obj, line, members):
        handle_lines.make_pin(line)
        return f"Pin '{line.name}' holds {wording.vertices(len(members))}"
