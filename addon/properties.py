# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept on an object: `object.meanvalue`."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import ids


class MEANVALUE_PG_anchor_group(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
    """One vertex group whose vertices are anchors"""

    name: StringProperty(
        name="Vertex Group",
        description="Vertex group whose vertices hold and pose the mesh",
        maxlen=ids.NAME_LENGTH,
    )


class MEANVALUE_PG_bound_record(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
    """What the mesh was bound as, see bridge/bound_record.py. Counts are for messages, digests for comparing"""

    is_bound: BoolProperty()
    vertex_count: IntProperty()
    face_count: IntProperty()
    faces: StringProperty()
    rest_shape: StringProperty()
    anchors: StringProperty()
    roi: StringProperty()
    settings: StringProperty()
    anchor_count: IntProperty()
    free_count: IntProperty()
    unheld_part_count: IntProperty()
    seconds: FloatProperty()

    is_solved: BoolProperty()
    solve_iterations: IntProperty()
    solve_energy: FloatProperty()
    solve_seconds: FloatProperty()
    solve_converged: BoolProperty()
    solve_stop_reason: StringProperty()


class MEANVALUE_PG_settings(bpy.types.PropertyGroup):  # noqa: N801  Blender's way
    """Settings of Mean-Value Deform for one object"""

    anchor_groups: CollectionProperty(type=MEANVALUE_PG_anchor_group)
    active_anchor_group: IntProperty(name="Active Anchor Group", min=0)
    roi_group: StringProperty(
        name="Region",
        description="Vertex group of the vertices that may move. Without one, the whole mesh may move",
        maxlen=ids.NAME_LENGTH,
    )
    roi_invert: BoolProperty(
        name="Invert",
        description="The vertices outside the group may move, those in it stay in place",
    )
    result_key: StringProperty(
        name="Result",
        description="Shape key that Solve writes, made if it is missing",
        default=ids.DEFAULT_RESULT_KEY,
        maxlen=ids.NAME_LENGTH,
    )
    former_result: StringProperty(options={'HIDDEN'})  # the shape key that the last solve wrote
    bound: PointerProperty(type=MEANVALUE_PG_bound_record)


CLASSES = (MEANVALUE_PG_anchor_group, MEANVALUE_PG_bound_record, MEANVALUE_PG_settings)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    setattr(bpy.types.Object, ids.OBJECT_PROPERTY, PointerProperty(type=MEANVALUE_PG_settings))


def unregister():
    delattr(bpy.types.Object, ids.OBJECT_PROPERTY)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
