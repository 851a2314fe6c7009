# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the region of influence: grown from a handle, or painted."""

import bpy
import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import subject
from ...widgets.base import MeshOperator
from ..bridge import controls, members, region

#: Distance to begin with, as a share of the bounding-box diagonal of the mesh.
FIRST_DISTANCE = 0.2


class MEANVALUE_OT_grow_region(MeshOperator, bpy.types.Operator):
    """Make the region by growing it over the surface from the active handle"""

    bl_label = "Grow Region from Handle"
    problems = (controls.none_active,)

    distance: bpy.props.FloatProperty(
        name="Distance",
        description="How far it reaches over the rest shape, in the object's units; at first a fifth of its size",
        default=1.0,
        min=0.0,
        subtype='DISTANCE',
    )
    extend: bpy.props.BoolProperty(
        name="Extend", description="Add to the region that is there, in place of replacing it", default=False
    )

    def run(self, obj):
        settings = obj.meanvalue
        region.require_own_group(obj)
        handle = settings.handles[settings.active_handle]
        members.require_listed(obj, handle)
        (seeds,) = members.of(obj, [handle])
        if len(seeds) == 0:
            raise SceneError(f"Handle '{handle.name}' has no vertices to grow from. Assign some, or choose another")
        if not self.properties.is_property_set("distance"):
            self.distance = region.radius(obj, FIRST_DISTANCE)
        distances = region.Surface(obj, seeds).distances(self.distance)
        weights = (distances <= self.distance).astype(float)
        if self.extend:
            weights = np.maximum(weights, region.weights(obj))
        region.write(obj, weights)
        count = wording.vertices(np.count_nonzero(weights))
        return f"The region '{settings.roi_group}' has {count} around '{handle.name}'", []


def _unpaintable(obj):
    """Why the object cannot be painted, in words, or None."""
    problem = None if obj.mode == 'WEIGHT_PAINT' else subject.mode_problem(obj)
    return problem or (None if obj.visible_get() else f"'{obj.name}' is hidden, so it cannot be painted. Show it first")


class MEANVALUE_OT_paint_region(MeshOperator, bpy.types.Operator):
    """Paint the region: what has a weight may move. Press again when it is right"""

    bl_label = "Paint Region"
    needs_object_mode = False
    problems = (_unpaintable,)

    def run(self, obj):
        if obj.mode == 'WEIGHT_PAINT':
            bpy.ops.object.mode_set(mode='OBJECT')
            return "The region is painted", []
        region.require_own_group(obj)
        group = region.ensure_group(obj)
        obj.vertex_groups.active_index = group.index
        subject.choose(obj)
        bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
        return f"Paint region '{group.name}': what has a weight may move. Press Paint Region again when it is right", []
