# SPDX-License-Identifier: GPL-3.0-or-later
"""The only file that knows differences between Blender versions (3.4 to 5.x), by features rather than by numbers."""

import contextlib

import bpy
import gpu

from . import ids


def position_store(mesh):
    """(collection, property) of vertex coordinates for foreach_get and _set: quicker a hundred times from 3.5 on."""
    attribute = mesh.attributes.get("position")
    return (attribute.data, "vector") if attribute else (mesh.vertices, "co")


def key_store(key):
    """(collection, property) of a shape key's coordinates; `points` (4.1 and later) is a hundred times quicker."""
    return (key.points if hasattr(key, "points") else key.data), "co"


def is_locked(key):
    """Whether a shape key is locked against edits, which later Blenders know."""
    return getattr(key, "lock_shape", False)


def points_tell_as_sliders(key):
    """Whether Blender tells of points of a key that a script wrote as it does of sliders; up to 4.2, of neither."""
    return hasattr(key, "points") and bpy.app.version >= (4, 3, 0)


def stored(obj):
    """What is kept of `object.meanvalue`, by its names, also what is not declared any more; None for nothing."""
    owner = obj.bl_system_properties_get() if hasattr(obj, "bl_system_properties_get") else obj  # 5.0 and later
    return owner.get(ids.OBJECT_PROPERTY) if owner is not None else None


def corner_store(mesh):
    """(collection, property, numbers of each, their type) of the vertex index of every face corner."""
    attribute = mesh.attributes.get(".corner_vert")
    return (attribute.data, "value", 1, "i4") if attribute else (mesh.loops, "vertex_index", 1, "u4")


def session_key(id_block):
    """Tells datablocks apart while the file is open, whatever they are called. Only for caches; do not store it."""
    return id_block.session_uid if _HAS_SESSION_UID else id_block.as_pointer()


_HAS_SESSION_UID = "session_uid" in bpy.types.ID.bl_rna.properties  # 4.2 and later; asked for hundreds of times a frame


def curves_to_write(id_block, action):
    """Gives `id_block` the action. Returns those of its F-curves that move it: from 4.4 on those of a slot."""
    animation = id_block.animation_data or id_block.animation_data_create()
    if animation.action != action:
        animation.action = action
    if not hasattr(action, "slots"):
        return action.fcurves
    if animation.action_slot is None:
        animation.action_slot = action.slots.new(id_type=id_block.id_type, name=id_block.name)
    layer = action.layers[0] if len(action.layers) else action.layers.new("Layer")
    strip = layer.strips[0] if len(layer.strips) else layer.strips.new(type='KEYFRAME')
    return strip.channelbag(animation.action_slot, ensure=True).fcurves


def is_shared(animation):
    """Whether keyframes in the action of `animation` move others too: from 4.4 on each has a slot of its own in it."""
    action = animation.action
    if not hasattr(action, "slots"):
        return action.users - int(action.use_fake_user) > 1
    return animation.action_slot is not None and len(animation.action_slot.users()) > 1


def has_slots_of_others(animation):
    """Whether the action of `animation` has keyframes of others, in slots of their own (4.4 and later)."""
    slots = getattr(animation.action, "slots", ())
    return any(slot != animation.action_slot and slot.users() for slot in slots)


def curves_to_read(id_block):
    """The F-curves that move `id_block`; none if it is not animated."""
    return curves_played(id_block.animation_data) if id_block.animation_data else ()


def curves_played(player):
    """The F-curves that an AnimData plays, or a strip of the NLA."""
    action = player.action
    if action is None:
        return ()
    if not hasattr(action, "slots"):
        return action.fcurves
    for layer in action.layers if player.action_slot else ():
        for strip in layer.strips:
            bag = strip.channelbag(player.action_slot)
            if bag is not None:
                return bag.fcurves
    return ()


def simulates(modifier):
    """Whether there is a simulation in a modifier of nodes (3.6 and later; from 4.1 on it tells)."""
    if hasattr(modifier, "bakes"):
        return any(each.node is not None and each.node.type == 'SIMULATION_OUTPUT' for each in modifier.bakes)
    return _has_simulation(modifier.node_group)


def _has_simulation(tree):
    nodes = tree.nodes if tree is not None and hasattr(bpy.types, "GeometryNodeSimulationOutput") else ()
    return any(each.type == 'SIMULATION_OUTPUT' or _has_simulation(getattr(each, "node_tree", None)) for each in nodes)


def add_geometry_sockets(tree):
    """Gives a new group of nodes its input and its output."""
    for side, collection in (('INPUT', "inputs"), ('OUTPUT', "outputs")):
        if hasattr(tree, collection):  # before 4.0
            getattr(tree, collection).new('NodeSocketGeometry', "Geometry")
        else:
            tree.interface.new_socket("Geometry", in_out=side, socket_type='NodeSocketGeometry')


def file_handler():
    """The class of what takes files that are dropped on a window (4.1 and later), or None."""
    return getattr(bpy.types, "FileHandler", None)


def shader(name):
    """The built-in shader `name`, as Blender 4.5 and later call it; its names begin with 3D before 4.0. Needs a window.

    Since 4.5 only the shaders made for points (POINT_...) take the size that is set.
    """
    plain = name.removeprefix("POINT_")
    for each in (name, plain):
        with contextlib.suppress(ValueError):
            return gpu.shader.from_builtin(each)
    return gpu.shader.from_builtin(f"3D_{plain}")


def flags_of_paths():
    """Options for a property with a path that may begin with //, where Blender wants to know (4.5 and later)."""
    known = bpy.types.Property.bl_rna.properties
    return {'PATH_SUPPORTS_BLEND_RELATIVE'} if "is_path_supports_blend_relative" in known else set()


def move_modifier(obj, modifier, index=0):
    """Makes `modifier` the first of the stack, or puts it at `index`. Blender 3.4 has only an operator for that."""
    if hasattr(obj.modifiers, "move"):
        obj.modifiers.move(obj.modifiers.find(modifier.name), index)
        return
    with bpy.context.temp_override(object=obj, active_object=obj, selected_objects=[obj]):
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=index)
