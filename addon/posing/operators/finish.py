# SPDX-License-Identifier: GPL-3.0-or-later
"""Ends posing: keeps the mesh as posed, and takes away what the add-on made for it."""

import bpy
import numpy as np

from ... import ids, wording
from ...live import engine
from ...scene import key_marks, new_rest, pose_key, selection, shape_keys, subject
from ...scene.core import point_sets
from ...scene.key_marks import Role
from ..bridge import controls, new_handles, posing, region
from .pose import SettledOperator

#: Of the mesh's size: what is nearer to the rest shape is no pose, since it was settled to no more than that.
SAME_POSE = 1e-4


def _problem(obj):
    """Why there is nothing to finish, or it is not this object's alone, as a sentence, or None."""
    if not obj.meanvalue.handles and not shape_keys.result(obj):
        return f"'{obj.name}' has no handles, pins or pose, so there is nothing to finish"
    if obj.meanvalue.baked.target:
        return shape_keys.BAKE_PLAYS
    ours = {handle.control for handle in obj.meanvalue.handles}
    for other in _with_the_pose(obj):
        if any(_is_own(other, handle, ours) for handle in other.meanvalue.handles):
            return f"'{other.name}' poses the same mesh by its own handles. Remove those, or make it a single user"
    return None


def _with_the_pose(obj):
    """The other objects whose pose is that of `obj`, as linked duplicates have it."""
    return [each for each in shape_keys.sharing(obj) if each.meanvalue.result_key == obj.meanvalue.result_key]


def _is_own(obj, handle, taken):
    """Whether a handle has a control that a linked duplicate has not merely taken over. taken: those of the other."""
    is_chosen = not handle.made_control and handle.control not in taken
    return handle.control is not None and (is_chosen or controls.owner_of(handle.control) == obj)


class MEANVALUE_OT_finish(SettledOperator, bpy.types.Operator):
    """Remove handles, pins and what was made for them, and keep the pose, or take it back"""

    bl_label = "Finish"
    problems = (_problem,)

    keep: bpy.props.EnumProperty(
        name="Keep",
        description="What becomes of the pose",
        items=(
            ('SHAPE_KEY', "As Shape Key", "Keep the pose as a shape key, fully on", 'SHAPEKEY_DATA', 0),
            ('REST', "As Rest Shape", "Make the pose the rest shape. Other shape keys go along", 'MESH_DATA', 1),
            ('NOTHING', "Nothing", "Take the pose back", 'X', 2),
        ),
        default='SHAPE_KEY',
    )

    @classmethod
    def description(cls, _context, properties):
        kept = properties.bl_rna.properties["keep"].enum_items[properties.keep].description
        return f"{kept}. Remove handles, pins and what was made for them"

    def prepare(self, obj):
        return None if self.keep == 'NOTHING' else super().prepare(obj)

    def use(self, obj):
        engine.look_again(obj)
        kept, notes = self._keep(obj)
        for other in _with_the_pose(obj):
            other.meanvalue.live = False
        removed = remove_what_was_made(obj)
        return f"{kept}. {removed} removed", [*notes, *subject.sharing_notes(obj)]

    def _keep(self, obj):
        """Returns (sentence, [notes])."""
        key, shape, rest = shape_keys.result(obj), shape_keys.result_positions(obj), shape_keys.rest_positions(obj.data)
        near = SAME_POSE * point_sets.bounding_box_diagonal(rest)
        is_posed = shape is not None and np.abs(shape - rest).max() > near
        notes = new_rest.become(obj) if is_posed and self.keep == 'REST' else []
        obj.meanvalue.live = False
        if is_posed and self.keep == 'SHAPE_KEY':
            if key.name == ids.DEFAULT_RESULT_KEY:
                key.name = new_handles.named_pose(obj, shape - rest)
            key.slider_min = key_marks.mark(Role.KEPT, key.name)
            return f"The pose is shape key '{key.name}'", []
        shape_keys.remove(obj, pose_key.names(obj))
        shape_keys.remove_lone_basis(obj)
        return "The pose is the rest shape now" if is_posed and self.keep == 'REST' else "The mesh is as it was", notes


def remove_what_was_made(obj):
    """Takes away all handles, what was made for them, the region and the binding. Returns how many, in words."""
    settings = obj.meanvalue
    count = len(settings.handles)
    if bpy.context.object != obj:
        selection.choose(obj)
    for index in reversed(range(count)):
        controls.remove_handle(obj, index)
    region.remove_made_group(obj)
    if settings.bound.is_bound:
        posing.release(settings.bound)
    for name in ("result_name", "result_mark"):
        settings.property_unset(name)
    return wording.counted(count, "handle or pin", "handles and pins")
