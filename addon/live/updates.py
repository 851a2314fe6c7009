# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's report of an evaluation says about mesh objects.

An object is named wherever its evaluated mesh is another, be it that a bone of its rig has moved. Its mesh is named
only where it was tagged, or has its shape keys mixed anew. What was tagged has all its flags, what is only evaluated
again (sliders that are driven or animated) that of its geometry alone. So in 3.4 to 5.0, see test_live_edits.py.
"""

import bpy

from .. import compat
from ..scene.object_model import Change


def of(depsgraph):
    """[(object, Change, whether its modifiers may make something else of it)] of mesh objects with other geometry."""
    objects, named = [], {}  # session key: the update of a datablock
    for update in depsgraph.updates:
        if not (update.is_updated_geometry or update.is_updated_transform):
            continue
        datablock = update.id.original
        named[compat.session_key(datablock)] = update
        if update.is_updated_geometry and isinstance(datablock, bpy.types.Object) and datablock.type == 'MESH':
            objects.append(datablock)
    return [(obj, *_change_of(obj, named)) for obj in objects]


def _change_of(obj, named):
    mesh = named.get(compat.session_key(obj.data))
    keys = named.get(compat.session_key(obj.data.shape_keys)) if obj.data.shape_keys else None
    if mesh is None and keys is None:
        return Change.RIG, True
    is_rigged = named[compat.session_key(obj)].is_updated_transform or any(
        compat.session_key(each) in named for each in _modified_by(obj)
    )
    if obj.data.is_editmode or keys is None or (mesh is not None and mesh.is_updated_shading):
        return Change.MESH, is_rigged
    return Change.KEYS if keys.is_updated_transform else Change.SLIDERS, is_rigged


def _modified_by(obj):
    """The objects that the modifiers take, and the one that `obj` hangs on, which may deform it."""
    if obj.parent is not None:
        yield obj.parent
    for modifier in obj.modifiers:
        for setting in modifier.bl_rna.properties:
            if setting.type == 'POINTER' and isinstance(setting.fixed_type, bpy.types.Object):
                other = getattr(modifier, setting.identifier)
                if other is not None:
                    yield other
