# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the region of influence by growing it from a handle."""

import bpy
import numpy as np

from ... import wording
from ...scene import shape_keys
from ...scene.core import fixed_points
from ...widgets.base import MeshOperator
from ..bridge import region

#: Distance to begin with, as a share of the bounding-box diagonal of the mesh.
FIRST_DISTANCE = 0.2


class MEANVALUE_OT_grow_region(MeshOperator, bpy.types.Operator):
    """Make the region by growing it over the surface from the active handle"""

    bl_idname = "meanvalue.grow_region"
    bl_label = "Grow Region from Handle"

    mode: bpy.props.EnumProperty(
        name="Grow by",
        description="How far the region reaches",
        items=(
            ('RINGS', "Rings", "By steps from vertex to vertex, whatever the size of the faces"),
            ('DISTANCE', "Distance", "By the length of the way along the edges of the rest shape"),
        ),
        default='DISTANCE',
    )
    rings: bpy.props.IntProperty(
        name="Rings", description="Number of steps along edges", default=5, min=0, soft_max=50, max=10000
    )
    distance: bpy.props.FloatProperty(
        name="Distance",
        description="Longest way along edges, in the object's own units, before its scale. If it was never given, a "
        "fifth of the mesh's size",
        default=1.0,
        min=0.0,
        subtype='DISTANCE',
        options={'SKIP_SAVE'},  # the next mesh may be of another size
    )
    extend: bpy.props.BoolProperty(
        name="Extend", description="Add to the region that is there, in place of replacing it", default=False
    )

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and obj.meanvalue.active_handle >= len(obj.meanvalue.handles):
            problem = "There is no handle to grow from. Press Add Handle, or click one in the list"
        return problem

    def run(self, obj):
        settings = obj.meanvalue
        region.require_own_group(obj)
        name = settings.handles[settings.active_handle].name
        weights = self._grown(obj, region.handle_members(obj, name)).astype(float)
        if self.extend:
            weights = np.maximum(weights, region.weights(obj))
        mask = weights > 0.0
        region.write(obj, weights)
        message = f"The region '{settings.roi_group}' has {wording.vertices(int(mask.sum()))} around '{name}'"
        return message, notes_on(obj, mask)

    def _grown(self, obj, seeds):
        if self.mode == 'RINGS':
            return region.grown(obj, seeds, self.rings, by_rings=True)
        if not self.properties.is_property_set("distance"):
            rest = shape_keys.rest_positions(obj.data)
            self.distance = FIRST_DISTANCE * fixed_points.bounding_box_diagonal(rest)
        return region.grown(obj, seeds, self.distance)

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "mode")
        layout.prop(self, "rings" if self.mode == 'RINGS' else "distance")
        layout.prop(self, "extend")


def notes_on(obj, mask):
    """Sentences on a region, n bool, that may not do what the artist expects of it."""
    notes = []
    outside = region.handles_outside(obj, mask)
    if outside:
        notes.append(
            f"{'Handle' if len(outside) == 1 else 'Handles'} {wording.quoted(outside)} "
            f"{'reaches' if len(outside) == 1 else 'reach'} out of it, where nothing follows: grow from there with "
            "Extend, or turn it off"
        )
    if mask.all():
        notes.append("That is the whole mesh")
    return notes
