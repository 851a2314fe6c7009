# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the vertices of a mesh are to be seen."""

import bpy

from . import mesh_arrays, rig_space, shape_keys

#: Modifiers that make vertices and leave those of the mesh the first ones.
_APPENDING = {'SUBSURF', 'MULTIRES'}

#: Modifiers that move vertices, and make and remove none.
_MOVING = (rig_space.DEFORMING - {'MESH_SEQUENCE_CACHE', 'NODES'}) | rig_space.HARMLESS | {'CLOTH', 'SOFT_BODY'}


#: With more vertices than these, what Subdivision makes is left alone: reading it would slow each redraw down.
MOST_SUBDIVIDED = 400_000


def positions(obj):
    """n x 3 float32: where the vertices are to be seen.

    Modifiers count as long as they keep the vertices, or put new ones behind them; else it is the result if it is
    shown, and the rest shape if not.
    """
    depsgraph = bpy.context.view_layer.depsgraph  # as it is: drawing must not evaluate anything
    evaluated = obj.evaluated_get(depsgraph).data if depsgraph is not None else obj.data
    count = len(obj.data.vertices)
    if len(evaluated.vertices) == count or (len(evaluated.vertices) > count and _are_first(obj)):
        return mesh_arrays.vertex_positions(evaluated)[:count]
    key = shape_keys.result(obj)
    result = shape_keys.result_positions(obj) if key and key.value > 0.0 and not key.mute else None
    return shape_keys.rest_positions(obj.data) if result is None else result


def all_positions(obj):
    """As positions(), with the vertices that Subdivision makes behind them; none, where it makes too many."""
    evaluated = subdivided(obj)
    return positions(obj) if evaluated is None else mesh_arrays.vertex_positions(evaluated)


def subdivided(obj):
    """The evaluated mesh, if a Subdivision is all that makes faces: each corner of a face of `obj` becomes as many
    quads, face after face. None else."""
    shown = [modifier.type for modifier in obj.modifiers if modifier.show_viewport]
    depsgraph = bpy.context.view_layer.depsgraph
    if depsgraph is None or sum(each in _APPENDING for each in shown) != 1 or not _are_first(obj):
        return None
    evaluated = obj.evaluated_get(depsgraph).data
    is_whole = len(obj.data.loops) > 0 and len(evaluated.polygons) % len(obj.data.loops) == 0
    is_made = len(obj.data.vertices) < len(evaluated.vertices) <= MOST_SUBDIVIDED
    return evaluated if is_whole and is_made else None


def _are_first(obj):
    """Whether the mesh's own vertices are the first ones of what the modifiers make."""
    shown = [modifier for modifier in obj.modifiers if modifier.show_viewport]
    return all(modifier.type in _APPENDING or modifier.type in _MOVING for modifier in shown)
