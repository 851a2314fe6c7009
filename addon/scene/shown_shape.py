# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the vertices of a mesh are to be seen."""

import bpy

from . import mesh_arrays, rig_space, shape_keys

#: Modifiers that make vertices and leave those of the mesh the first ones.
_APPENDING = {'SUBSURF', 'MULTIRES'}

#: Modifiers that move vertices, and make and remove none.
_MOVING = (rig_space.DEFORMING - {'MESH_SEQUENCE_CACHE', 'NODES'}) | rig_space.HARMLESS | {'CLOTH', 'SOFT_BODY'}


def positions(obj):
    """n x 3 float32: where the vertices are to be seen.

    Modifiers count as long as they keep the vertices, or put new ones behind them; else it is the result if it is
    shown, and the rest shape if not.
    """
    depsgraph = bpy.context.view_layer.depsgraph  # as it is: drawing must not evaluate anything
    evaluated = obj.evaluated_get(depsgraph).data if depsgraph is not None else obj.data
    count, shown = len(obj.data.vertices), {each.type for each in obj.modifiers if each.show_viewport}
    if len(evaluated.vertices) == count or (len(evaluated.vertices) > count and shown <= _APPENDING | _MOVING):
        return mesh_arrays.vertex_positions(evaluated)[:count]
    key = shape_keys.result(obj)
    result = shape_keys.result_positions(obj) if key and key.value > 0.0 and not key.mute else None
    return shape_keys.rest_positions(obj.data) if result is None else result
