# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices each handle has.

A handle that the add-on made has those that an attribute of the mesh marks as its own, which is read at once, and which
nobody paints or renames. A handle of a vertex group, as all of older files, has the vertices of that.

A mark k is the pair (k, k * k) in the attribute, a point of a parabola. What subdividing puts between two vertices has
a mean of their pairs: that is the same pair if one handle has both; else it lies above the parabola, and is no mark.
Where handles share vertices they are marked in several attributes, the *layers*.
"""

import itertools

import bpy
import numpy as np

from ... import ids
from ...scene import shape_keys, vertex_groups

#: Marks of a layer: so many squares are exact enough in float32 after averaging.
PER_LAYER = 512

#: How far a pair may be off its mark by rounding.
OFF, OFF_SQUARE = 0.01, 0.5


def of(obj, handles):
    """[ascending vertex indices, int32] of each of `handles`; none where its group or its marks are gone."""
    groups = vertex_groups.members(obj, [handle.name for handle in handles if not handle.mark])
    layers = {layer: _marked(obj.data, layer) for layer in {each.mark // PER_LAYER for each in handles if each.mark}}
    found = []
    for handle in handles:
        if handle.mark:
            vertices, marks = layers[handle.mark // PER_LAYER]
            found.append(vertices[marks == handle.mark])
        else:
            found.append(groups.get(handle.name, np.empty(0, np.int32)))
    return found


def is_missing(obj, handle):
    """Whether the vertex group of a handle is gone. Cheap enough for drawing."""
    return not handle.mark and handle.name not in obj.vertex_groups


def require_listed(obj, handle):
    """@throws SceneError if is_missing()."""
    if is_missing(obj, handle):
        remedy = "Choose another group in Active Handle, or remove the handle"
        vertex_groups.require(obj, handle.name, "on the list of handles", remedy)


def make(obj, handle, name, vertices):
    """Has a new handle hold `vertices`, called `name`, or numbered where a handle or a vertex group is called so."""
    give(obj, handle, vertices)
    handle.name = vertex_groups.unused(name, {*obj.meanvalue.handles.keys(), *obj.vertex_groups.keys()})


def give(obj, handle, vertices):
    """Has a handle that the add-on made hold `vertices`, and no others. What other handles have stays theirs."""
    mesh = obj.data
    own = [each.mark for other in (obj, *shape_keys.sharing(obj)) for each in other.meanvalue.handles if each != handle]
    # Of all objects, so that no two handles are one after objects were joined.
    taken = {each.mark for other in bpy.data.objects for each in other.meanvalue.handles if each != handle}
    for layer in itertools.count():
        held, marks = _marked(mesh, layer)
        is_owned = np.isin(marks, own)
        held, marks = held[is_owned], marks[is_owned] % PER_LAYER
        free = set(range(layer * PER_LAYER + 1, (layer + 1) * PER_LAYER)) - taken
        is_others = _name(layer) in mesh.attributes and _attribute(mesh, layer) is None
        if free and not is_others and not np.isin(vertices, held).any():
            break
    handle.mark = min(free)
    pairs = np.zeros((len(mesh.vertices), 2), np.float32)
    pairs[held] = np.stack([marks, marks**2], axis=1)
    pairs[vertices] = handle.mark % PER_LAYER, (handle.mark % PER_LAYER) ** 2
    attribute = _attribute(mesh, layer) or mesh.attributes.new(_name(layer), 'FLOAT2', 'POINT')
    attribute.data.foreach_set("vector", pairs.ravel())
    mesh.update_tag()


def tidy(obj, mark):
    """After a handle with this mark was removed: takes its layer away, if no handle has marks there."""
    others = (each.mark for other in (obj, *shape_keys.sharing(obj)) for each in other.meanvalue.handles)
    attribute = _attribute(obj.data, mark // PER_LAYER)
    if mark and attribute is not None and all(each // PER_LAYER != mark // PER_LAYER for each in others if each):
        obj.data.attributes.remove(attribute)


def _name(layer):
    return f"{ids.HANDLES_ATTRIBUTE}{layer or ''}"


def _attribute(mesh, layer):
    """None where there is none, or what has its name is another's."""
    found = mesh.attributes.get(_name(layer))
    is_ours = found is not None and (found.data_type, found.domain) == ('FLOAT2', 'POINT')
    return found if is_ours else None


def _marked(mesh, layer):
    """(ascending vertex indices, their marks), int32, of a layer; none in Edit Mode, which has its own copy."""
    attribute = _attribute(mesh, layer)
    pairs = np.zeros((0 if attribute is None else len(attribute.data), 2), np.float32)
    if len(pairs):
        attribute.data.foreach_get("vector", pairs.ravel())
    vertices = np.flatnonzero(pairs[:, 0])
    values, squares = pairs[vertices].T
    marks = np.rint(values)
    is_mark = (marks > 0.0) & (np.abs(values - marks) < OFF) & (np.abs(squares - marks**2) < OFF_SQUARE)
    return vertices[is_mark].astype(np.int32), layer * PER_LAYER + marks[is_mark].astype(np.int32)
