# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything about an object that an operator could change, as one comparable dict."""

import bpy
import numpy as np


def snapshot(obj, without=()):
    """{what: value}; arrays as bytes, so that equal means the same bits. Leave things out by name."""
    taken = {
        **_mesh(obj.data),
        **_object(obj),
        **_keys(obj),
        "settings": _properties(obj.meanvalue),
        "datablocks": {
            name: sorted(block.name for block in getattr(bpy.data, name))
            for name in ("meshes", "objects", "shape_keys", "materials")
        },
    }
    return {what: value for what, value in taken.items() if what not in without}


def assert_same(before, after):
    """As `==`, naming what differs."""
    assert [what for what in before if before[what] != after.get(what)] == []
    assert before == after


def _read(collection, attribute, width, kind):
    values = np.empty(len(collection) * width, kind)
    collection.foreach_get(attribute, values)
    return values.tobytes()


def _mesh(mesh):
    return {
        "vertices": _read(mesh.vertices, "co", 3, np.float32),
        "edges": _read(mesh.edges, "vertices", 2, np.int32),
        "corners": _read(mesh.loops, "vertex_index", 1, np.int32),
        "faces": _read(mesh.polygons, "loop_start", 1, np.int32) + _read(mesh.polygons, "loop_total", 1, np.int32),
        "materials": (mesh.materials.keys(), _read(mesh.polygons, "material_index", 1, np.int32)),
        "smooth": _read(mesh.polygons, "use_smooth", 1, bool),
        "uv": {layer.name: _read(layer.data, "uv", 2, np.float32) for layer in mesh.uv_layers},
    }


def _object(obj):
    return {
        "mode": obj.mode,
        "matrix": tuple(tuple(row) for row in obj.matrix_world),
        "modifiers": [modifier.name for modifier in obj.modifiers],
        "groups": [group.name for group in obj.vertex_groups],
        "weights": [[(g.group, g.weight) for g in vertex.groups] for vertex in obj.data.vertices],
        "active group": obj.vertex_groups.active_index,
    }


def _keys(obj):
    keys = obj.data.shape_keys
    return {
        "active key": obj.active_shape_key_index,
        "pinned": obj.show_only_shape_key,
        "relative": keys.use_relative if keys else None,
        "keys": [_key(key) for key in keys.key_blocks] if keys else None,
    }


def _key(key):
    state = ("name", "value", "mute", "slider_min", "slider_max", "vertex_group", "interpolation")
    return (
        *(getattr(key, name) for name in state),
        key.relative_key.name,
        _read(key.data, "co", 3, np.float32),
    )


def _properties(group):
    values = {}
    for prop in group.bl_rna.properties:
        if prop.identifier == "rna_type":
            continue
        value = getattr(group, prop.identifier)
        if prop.type == 'COLLECTION':
            value = [_properties(item) for item in value]
        elif prop.type == 'POINTER':
            value = _pointed_at(value)
        elif getattr(prop, "is_array", False):
            value = tuple(value)
        values[prop.identifier] = value
    return values


def _pointed_at(value):
    return value.name if isinstance(value, bpy.types.ID) else _properties(value) if value else None
