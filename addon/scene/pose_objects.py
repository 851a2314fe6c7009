# SPDX-License-Identifier: GPL-3.0-or-later
"""Pose objects: what meshes of other files are posed by in this one.

Of what is linked or overridden Blender saves neither new shape keys nor our settings. So a hidden object of this file,
with a copy of the mesh, is posed in its place, as others are, and the modifier Pose of what is shown adds that.
"""

import bpy

from .. import ids, wording


def of(obj):
    """The pose object of a mesh object that is shown, or None. Cheap enough for drawing."""
    modifiers = obj.modifiers if obj is not None and obj.type == 'MESH' else ()
    return next((each for each in map(read_by, modifiers) if each is not None and each.parent == obj), None)


def read_by(modifier):
    """The object whose pose a modifier Pose adds, or None."""
    if not is_ours(modifier):
        return None
    found = [node.inputs["Object"].default_value for node in modifier.node_group.nodes if node.type == 'OBJECT_INFO']
    return found[0] if found else None


def is_ours(modifier):
    """Whether a modifier has nodes that the add-on has made: of poses they tell, and deform nothing themselves."""
    return modifier.type == 'NODES' and modifier.node_group is not None and ids.POSE_NODES_MARK in modifier.node_group


def shown(obj):
    """What is seen in place of a mesh object: what a pose object poses, or itself."""
    return obj.parent if obj.parent is not None and of(obj.parent) == obj else obj


def is_foreign(obj):
    """Whether a mesh object, or its mesh, is another file's, and a pose object can be made for it."""
    if not isinstance(obj, bpy.types.Object) or obj.type != 'MESH' or obj.library is not None:
        return False
    return any(each is not None for each in (obj.override_library, obj.data.override_library, obj.data.library))


def problem(obj):
    """Why a pose object cannot be posed, or None."""
    there, own = len(shown(obj).data.vertices), len(obj.data.vertices)
    if there == own:
        return None
    name = shown(obj).name
    return f"'{name}' has {wording.vertices(there)} now, and its pose is of {own:,}: it waits in '{obj.name}', unseen"
