# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses the mesh once by a shape key."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...scene import shape_keys, vertex_groups
from ..bridge import controls, new_handles, scene_input, targets
from ..bridge.posing import Posing
from .solving import SolvingOperator


class MEANVALUE_OT_solve_from_key(SolvingOperator, bpy.types.Operator):
    """Put handles and pins where a shape key has their vertices, and the rest of the mesh after them, once"""

    bl_idname = "meanvalue.solve_from_key"
    bl_label = "Solve from Shape Key"

    key: bpy.props.StringProperty(
        name="Shape Key",
        description="Shape key in which vertices of handles were moved. If empty, the active one",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    groups: bpy.props.StringProperty(
        name="Vertex Groups",
        description="Where there are no handles: vertex groups to pin, with commas between, such as: hand, feet",
        options={'SKIP_SAVE'},
    )

    _pins = ()  # names of those that were made

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and obj.data.shape_keys is None:
            problem = (
                "There are no shape keys. Add one, move the vertices of handles in it, in Edit Mode, and choose it"
            )
        return problem

    def start_reading(self, obj):
        self._prepare_scene(obj)
        return scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        self._prepare_scene(obj)
        return Posing(obj, reading, self.key)

    def finish(self, obj, posing, outcome):
        notes = list(_ignored(obj, posing.bind_input, self.key))
        if obj.meanvalue.live:
            obj.meanvalue.live = False
            notes.append("Live is off: it would have the controls pose the mesh again")
        key = obj.data.shape_keys.key_blocks[self.key]
        message, warnings = super().finish(obj, posing, outcome)
        self._pins = ()  # Repeat Last goes on with this instance
        if self.key != obj.meanvalue.result_key and key.value != 0.0:
            key.value = 0.0
            message += f". Shape key '{self.key}' has the value 0 now, so that it is not added"
        return message, [*warnings, *notes]

    def refuse(self, error):
        obj = bpy.data.objects.get(self._object_name)
        for name in self._pins if obj else ():
            if name in obj.meanvalue.handles:
                controls.remove_handle(obj, obj.meanvalue.handles.find(name))
        self._pins = ()
        return super().refuse(error)

    def _prepare_scene(self, obj):
        """@throws SceneError before anything is changed."""
        self.key = self.key or _active_key(obj)
        problem = shape_keys.result_problem(obj)
        if problem:
            raise SceneError(problem)
        if not obj.meanvalue.handles and self.groups.strip():
            names = [name.strip() for name in self.groups.split(",") if name.strip()]
            for name in names:
                vertex_groups.require(obj, name, "to be pinned", "Choose one that it has")
            targets.require_key(obj, self.key)
            for name in names:
                new_handles.make_pin(new_handles.add_handle(obj, (), group=name))
            self._pins = names


def _active_key(obj):
    active, keys = obj.active_shape_key, obj.data.shape_keys
    if active is None or active == keys.reference_key:
        raise SceneError(
            "The active shape key is the rest shape, or there is none, so nothing is posed. Add a shape key, move the "
            "vertices of handles in it, in Edit Mode, and choose it"
        )
    return active.name


def _ignored(obj, bind_input, name):
    """A sentence on vertices that were moved in the shape key and are not solved from there."""
    if name == obj.meanvalue.result_key:
        return
    moved = (shape_keys.positions(obj.data.shape_keys.key_blocks[name]) != bind_input.rest).any(axis=1)
    moved[bind_input.anchors] = False
    count = np.count_nonzero(moved)
    if count:
        yield f"{wording.counted(count, 'vertex', 'vertices')} moved in '{name}' belong to no handle and are ignored"
