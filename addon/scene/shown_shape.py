# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the vertices of a mesh are to be seen."""

import bpy
import numpy as np

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


def hit(evaluated, origin, direction):
    """How many times `direction` a ray goes to what an evaluated mesh object shows, in its space, (3,) float64 each;
    infinite if it misses. Blender's ray_cast() takes ten times as long: it makes a tree of all triangles first."""
    positions = mesh_arrays.vertex_positions(evaluated.data)
    triangles = mesh_arrays.shown_triangles(evaluated.data)
    flat = (positions - origin) @ np.linalg.svd(direction[None])[2][1:].T  # as seen along the ray
    sides = np.left_shift(1, flat[:, 0] >= 0.0, dtype=np.uint8) | np.left_shift(4, flat[:, 1] >= 0.0, dtype=np.uint8)
    sides = sides[triangles]
    near = triangles[(sides[:, 0] | sides[:, 1] | sides[:, 2]) == 15]  # others are on one side of it
    x, y = np.moveaxis(flat[near], 2, 0)
    areas = x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y  # to the bit: no gaps at edges
    sums = areas.sum(axis=1, keepdims=True)
    shares = np.roll(areas, -1, axis=1) / np.where(sums == 0.0, np.nan, sums)
    ways = ((shares[..., None] * positions[near]).sum(axis=1) - origin) @ direction / (direction @ direction)
    return ways[(shares >= 0.0).all(axis=1) & (ways >= 0.0)].min(initial=np.inf)
