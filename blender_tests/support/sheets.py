# SPDX-License-Identifier: GPL-3.0-or-later
"""A wavy sheet that is grabbed in its middle."""

import bpy
import numpy as np

from . import handles, meshes

COLUMNS = 31
MIDDLE = COLUMNS * COLUMNS // 2
#: Along the middle row, off from the middle.
BESIDE = MIDDLE + 9


def sheet():
    return meshes.grid(COLUMNS, COLUMNS, "Sheet")


def grab(vertex=MIDDLE, offset=(0.0, 0.0, 2.0), **options):
    assert bpy.ops.meanvalue.grab(vertex=vertex, offset=offset, **options) == {'FINISHED'}
    handles.update()


def pin(vertex, **options):
    assert bpy.ops.meanvalue.grab(vertex=vertex, pin=True, **options) == {'FINISHED'}
    handles.update()


def region_weights(obj):
    group = obj.vertex_groups[obj.meanvalue.roi_group].index
    weights = np.zeros(len(obj.data.vertices))
    for vertex in obj.data.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights


def lift(obj):
    """n: how far each vertex is lifted."""
    return (handles.shown(obj) - handles.rest(obj))[:, 2]
