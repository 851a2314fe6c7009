# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes pose objects, and takes them away. All plays without the add-on:

    the pose object       Pose Offset: how far a vertex is from home, as an attribute | deforming modifiers
    what is shown         Pose: adds the attribute, by the vertex's number | its own modifiers

Both come before the rig. Where the numbers of vertices differ, nothing is added. Point caches come before Pose Offset.
"""

import contextlib
import itertools

import bpy
import numpy as np

from .. import compat, ids
from . import mesh_arrays, pose_objects, rig_space, shape_keys


@contextlib.contextmanager
def ready(obj):
    """Gives (what to pose, [sentences]): `obj`, or a pose object made for it, which goes if what is inside fails."""
    if not pose_objects.is_foreign(obj):
        yield obj, []
        return
    was_system, made = is_system(obj), make(obj)
    notes = [f"The library override of '{obj.name}' is editable now"] if was_system else []
    try:
        yield made, [f"'{made.name}' holds the pose of '{obj.name}' in this file", *notes]
    except Exception:
        remove(made)
        raise


def is_system(obj):
    """Whether `obj` is an override that Blender has artists not edit."""
    return obj.override_library is not None and obj.override_library.is_system_override


def make(obj):
    """The pose object of `obj`, which is foreign."""
    if is_system(obj):
        obj.override_library.is_system_override = False
    made = _copy(obj)
    _equip(obj, made)
    return made


def _copy(obj):
    """Hidden, in its place, with the mesh as it is at rest."""
    rest, mesh = shape_keys.rest_positions(obj.data), obj.data.copy()
    made = bpy.data.objects.new(f"{obj.name} Pose", mesh)
    if mesh.shape_keys is not None:
        made.shape_key_clear()
    store, name = compat.position_store(mesh)
    store.foreach_set(name, rest.ravel())
    mesh.attributes.new(ids.HOME_ATTRIBUTE, 'FLOAT_VECTOR', 'POINT').data.foreach_set("vector", rest.ravel())
    made.parent, made.hide_render, made.display_type = obj, True, 'BOUNDS'
    homes = [each for each in obj.users_collection if each.library is None and each.override_library is None]
    for home in homes or [bpy.context.scene.collection]:
        home.objects.link(made)
    scenes = [each for each in bpy.data.scenes if each.objects.get(made.name) == made]
    for layer in (each for scene in scenes for each in scene.view_layers):
        layer.update()  # which finds what was linked
        if layer.objects.get(made.name) == made:
            made.hide_set(True, view_layer=layer)  # by the eye: of what is disabled Blender tells no edit
    return made


def _equip(obj, made):
    """Adds the modifiers."""
    for modifier in list(obj.modifiers):
        if pose_objects.is_ours(modifier):  # of what it was duplicated from, or of a pose object that is gone
            obj.modifiers.remove(modifier)
    copying = {"selected_objects": [made], "selected_editable_objects": [made]}
    with bpy.context.temp_override(object=obj, active_object=obj, **copying):
        bpy.ops.object.make_links_data(type='MODIFIERS')  # with what they are bound to, which no property tells
    for modifier in list(made.modifiers):
        if modifier.type not in rig_space.DEFORMING - {'NODES'}:
            made.modifiers.remove(modifier)
    if obj.parent is not None and obj.parent_type in rig_space.DEFORMING_PARENTS:
        modifier = made.modifiers.new(obj.parent.name, obj.parent_type)  # which does the same
        modifier.object = obj.parent
        compat.move_modifier(made, modifier)
    for owner, name, tree in ((made, "Pose Offset", _offset_nodes()), (obj, "Pose", _adding_nodes(obj, made))):
        modifier = owner.modifiers.new(name, 'NODES')
        modifier.node_group, modifier.show_expanded = tree, False
        compat.move_modifier(owner, modifier)
    bpy.context.view_layer.update()


VECTORS = {"data_type": 'FLOAT_VECTOR'}
OF_POINTS = {**VECTORS, "domain": 'POINT'}


def _offset_nodes():
    """The same for all pose objects."""
    for tree in bpy.data.node_groups:
        if tree.library is None and tree.get(ids.POSE_NODES_MARK) == "offset":
            return tree
    tree, mesh = _new_tree("Mesh Pose Offset", "offset")
    home = _add(tree, 'GeometryNodeInputNamedAttribute', {"Name": ids.HOME_ATTRIBUTE}, **VECTORS)
    places = {0: _add(tree, 'GeometryNodeInputPosition'), 1: home}
    told = {"Name": ids.OFFSET_ATTRIBUTE, "Value": _add(tree, 'ShaderNodeVectorMath', places, operation='SUBTRACT')}
    stored = _add(tree, 'GeometryNodeStoreNamedAttribute', {"Geometry": mesh, **told}, **OF_POINTS)
    _add(tree, 'NodeGroupOutput', {0: stored})
    return tree


def _adding_nodes(obj, made):
    tree, mesh = _new_tree(f"Mesh Pose of {obj.name}", "pose")
    source = _add(tree, 'GeometryNodeObjectInfo', {"Object": made}, "Geometry", transform_space='ORIGINAL')
    offset = _add(tree, 'GeometryNodeInputNamedAttribute', {"Name": ids.OFFSET_ATTRIBUTE}, **VECTORS)
    sampled = {"Geometry": source, "Value": offset, "Index": _add(tree, 'GeometryNodeInputIndex')}
    move = {"Geometry": mesh, "Offset": _add(tree, 'GeometryNodeSampleIndex', sampled, **OF_POINTS)}
    counts = {"A": mesh, "B": source}
    counts = {side: _add(tree, 'GeometryNodeAttributeDomainSize', {0: each}) for side, each in counts.items()}
    move["Selection"] = _add(tree, 'FunctionNodeCompare', counts, data_type='INT', operation='EQUAL')
    _add(tree, 'NodeGroupOutput', {0: _add(tree, 'GeometryNodeSetPosition', move)})
    return tree


def _new_tree(name, kind):
    """(tree, the socket that its geometry comes from)."""
    tree = bpy.data.node_groups.new(name, 'GeometryNodeTree')
    tree[ids.POSE_NODES_MARK] = kind
    compat.add_geometry_sockets(tree)
    return tree, _add(tree, 'NodeGroupInput')


def _add(tree, kind, inputs=(), output=0, **settings):
    """Adds a node, and returns its output socket. inputs: {name or number: socket to link, or value}; a name stands for
    a socket of each type of data, of which one is in use."""
    node = tree.nodes.new(kind)
    node.location.x = 180.0 * len(tree.nodes)
    for name, value in settings.items():
        setattr(node, name, value)
    for name, value in dict(inputs).items():
        socket = node.inputs[name] if name in (0, 1) else next(s for s in node.inputs if s.enabled and s.name == name)
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    used = [each for each in node.outputs if each.enabled]
    return node.outputs[output] if output else next(iter(used), None)


def _plays_places(made):
    """Whether a cache comes before Pose Offset: the places in it are of the rest shape that `made` had by then."""
    before = itertools.takewhile(lambda each: not pose_objects.is_ours(each), made.modifiers)
    return any(each.type in {'MESH_CACHE', 'MESH_SEQUENCE_CACHE'} for each in before)


def take_over_rests():
    """Where the file of what is shown has given that another rest shape, the pose object takes it over, and its keys
    add what they did: an edit; Live waits for Update. Not while a cache plays, nor NaN, which would stay for good."""
    found = [(each, pose_objects.of(each)) for each in bpy.data.objects]
    for obj, made in [each for each in found if each[1] is not None]:
        mesh = made.data
        home = mesh.attributes.get(ids.HOME_ATTRIBUTE)
        if home is None or pose_objects.problem(made) is not None or mesh.is_editmode or _plays_places(made):
            continue
        rest, former = shape_keys.rest_positions(obj.data), mesh_arrays.coordinates(home.data, "vector")
        if np.array_equal(rest, former) or not np.isfinite(rest).all():
            continue
        keys = () if mesh.shape_keys is None else mesh.shape_keys.key_blocks
        for key in keys:
            shape_keys.write_positions(mesh, key, shape_keys.positions(key) + (rest - former))
        store, name = compat.position_store(mesh)
        store.foreach_set(name, (mesh_arrays.vertex_positions(mesh) + (rest - former)).ravel())
        home.data.foreach_set("vector", rest.ravel())
        mesh.update()


def remove_bare(obj):
    """Takes `obj` away if it is a pose object that tells nothing: no handle, key nor cache, its rest shape as made."""
    home = obj.data.attributes.get(ids.HOME_ATTRIBUTE)
    if home is None or pose_objects.shown(obj) == obj or obj.data.shape_keys is not None:
        return
    if obj.meanvalue.handles or _plays_places(obj):
        return
    if np.array_equal(mesh_arrays.coordinates(home.data, "vector"), mesh_arrays.vertex_positions(obj.data)):
        remove(obj)


def remove(made):
    """Takes a pose object away, and what shows it."""
    for obj in bpy.data.objects:
        for modifier in [each for each in obj.modifiers if obj == made or pose_objects.read_by(each) == made]:
            tree = getattr(modifier, "node_group", None)
            obj.modifiers.remove(modifier)
            if tree is not None and tree.users == 0:
                bpy.data.node_groups.remove(tree)
    mesh = made.data
    bpy.data.objects.remove(made)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)
