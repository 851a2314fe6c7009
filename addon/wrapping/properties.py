# SPDX-License-Identifier: GPL-3.0-or-later
"""What Wrap fits an object onto, and the pairs that it goes by: `object.meanvalue.wrap`."""

import bpy
from bpy.props import CollectionProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty

from ..scene.declarations import aside


class MEANVALUE_PG_wrap_pair(bpy.types.PropertyGroup):
    """A vertex of the mesh and where it belongs on the other one"""

    vertex: IntProperty(name="Vertex", description="Vertex of this mesh", min=0)
    place: FloatVectorProperty(
        name="Place", description="Where it belongs on the other mesh, in that object's own space", size=3
    )


class MEANVALUE_PG_wrap(bpy.types.PropertyGroup):
    """The other mesh, and picked pairs"""

    target: PointerProperty(
        name="Onto",
        description="Mesh whose shape this one takes. It may have any faces, modifiers and pose",
        type=bpy.types.Object,
        poll=lambda group, candidate: candidate.type == 'MESH' and candidate != group.id_data,
    )
    keys: StringProperty(
        name="Keys", description="Which shape keys of the other mesh to carry: names, or jaw*, eye*. If empty: all"
    )
    replace: bpy.props.BoolProperty(
        name="Replace", description="Write over shape keys of the same name that are here already"
    )
    pairs: CollectionProperty(type=MEANVALUE_PG_wrap_pair)


SETTINGS = {"wrap": aside(PointerProperty)(type=MEANVALUE_PG_wrap)}
