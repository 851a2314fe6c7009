# SPDX-License-Identifier: GPL-3.0-or-later
"""What rigs and other shape keys do to a mesh: measured by evaluating them, with no knowledge of what they are.

Positions are written into Blender's evaluated copy of the key (or of the mesh, where there are no keys), the modifiers
that deform are run on them, and the copy is put back: the scene is neither changed nor evaluated, and no handler runs.
A copy of the object would not do: linked into the scene, it has Blender build its graph of dependencies anew, and it is
not what hooks, binds and parents are tied to. It is safe: the copies belong to the graph alone, and nothing draws or
evaluates between writing and putting back. Modifiers that make vertices are left out: what deforms does the same to the
vertices of the mesh without them. And where the vertices are to be seen.
"""

import contextlib
import dataclasses
import itertools

import bpy
import numpy as np

from .. import compat, wording
from ..errors import SceneError
from ..rooms import ALL
from . import key_marks, mesh_arrays, pose_objects, shape_keys, views
from .baked import hidden, names_in
from .core.point_sets import bounding_box_diagonal
from .core.seen_space import SeenSpace

#: Modifiers that only move vertices. Simulations are not asked: that would disturb their caches.
DEFORMING = {
    'ARMATURE', 'CAST', 'CORRECTIVE_SMOOTH', 'CURVE', 'DISPLACE', 'HOOK', 'LAPLACIANDEFORM', 'LAPLACIANSMOOTH',
    'LATTICE', 'MESH_CACHE', 'MESH_DEFORM', 'MESH_SEQUENCE_CACHE', 'NODES', 'SHRINKWRAP', 'SIMPLE_DEFORM', 'SMOOTH',
    'SURFACE_DEFORM', 'VOLUME_DISPLACE', 'WARP', 'WAVE',
}  # fmt: skip

#: Those of them where a vertex depends on its neighbours: what one does when it moves alone is not what the whole does.
NEIGHBOURLY = {'CORRECTIVE_SMOOTH', 'LAPLACIANDEFORM', 'LAPLACIANSMOOTH', 'NODES', 'SMOOTH'}

#: Modifiers that leave vertices alone.
HARMLESS = {
    'COLLISION', 'DATA_TRANSFER', 'NORMAL_EDIT', 'PARTICLE_SYSTEM', 'SURFACE', 'UV_PROJECT', 'UV_WARP',
    'VERTEX_WEIGHT_EDIT', 'VERTEX_WEIGHT_MIX', 'VERTEX_WEIGHT_PROXIMITY', 'WEIGHTED_NORMAL',
}  # fmt: skip

#: Modifiers that make vertices and leave those of the mesh the first ones.
_APPENDING = {'SUBSURF', 'MULTIRES'}

#: Modifiers that move vertices, and make and remove none.
SIMULATING = {'CLOTH', 'SOFT_BODY'}
_MOVING = (DEFORMING - {'MESH_SEQUENCE_CACHE', 'NODES'}) | HARMLESS | SIMULATING

#: Parents that deform their children as a modifier does.
DEFORMING_PARENTS = {'ARMATURE', 'LATTICE', 'CURVE'}

#: How far the key is displaced to see what comes of it, and to see whether that is all there is to it, as shares of the
#: mesh's size; and how straight that has to be. Positions have float32 noise, and lattices bend.
STEP, PROBE = 0.05, 0.2
STRAIGHT = 4e-6


def is_there(obj):
    """Whether anything is between the pose's key and what is seen. Cheap enough for each step of a drag."""
    return bool(deformers(obj) or sliders(obj))


def armature(obj):
    """The armature that moves `obj`, or None."""
    return next((rig for rig in (*armatures(obj), obj.parent) if rig is not None and rig.type == 'ARMATURE'), None)


def armatures(obj):
    """Those of its modifiers, but not that of a bake."""
    baked = obj.meanvalue.baked.modifier
    return [each.object for each in obj.modifiers if each.type == 'ARMATURE' and each.object and each.name != baked]


def before_bones(obj, is_seen=True):
    """Its modifiers that bones can stand for, before any that makes vertices; nodes at the end only if alone. Not
    is_seen: before simulations, whose caches are of what the scene shows."""
    known = (_MOVING | {'MESH_SEQUENCE_CACHE', 'NODES'}) - (set() if is_seen else SIMULATING)
    first = itertools.takewhile(lambda each: each.type in known or not _is_on(obj, each), obj.modifiers)
    found = [each for each in first if _deforms(obj, each) or (each.type in SIMULATING and _is_on(obj, each))]
    ends = [number for number, each in enumerate(found, 1) if each.type != 'NODES']
    return found[: ends[-1]] if ends else found


def sliders(obj):
    """The values of the shape keys beside the pose's, of those that are shown."""
    keys = obj.data.shape_keys
    if keys is None or not keys.use_relative:
        return ()
    own = _pose_keys(obj)
    return tuple((key.name, key.value) for key in keys.key_blocks[1:] if key.name not in own and _counts(obj, key))


def named(obj):
    """What deforms the object behind its key, in words."""
    names = [each.name for each in deformers(obj)]
    return wording.quoted(names) if names else "its shape keys"


def measure(obj):
    """The SeenSpace of `obj` as it was evaluated last, or None where every vertex is seen where its key has it. Takes
    five evaluations of the modifiers. @throws SceneError where it cannot be told: without a rig the pose would be lost.
    """
    if not is_there(obj):
        return None
    size = bounding_box_diagonal(shape_keys.rest_positions(obj.data))
    if not (np.isfinite(size) and size > 0.0):
        return None
    with evaluating(obj) as evaluate:
        space = measured(obj, evaluate)
    return None if space.is_identity else space


def measured(obj, evaluate):
    """As measure(), by a function of evaluating()."""
    rest = shape_keys.rest_positions(obj.data).astype(np.float64)
    size, seen, jacobians = bounding_box_diagonal(rest), evaluate(rest), np.empty((len(rest), 3, 3))
    for axis in range(3):
        jacobians[:, :, axis] = (evaluate(rest + STEP * size * np.eye(3)[axis]) - seen) / (STEP * size)
    probe = PROBE * size * np.array((1.0, -1.0, 1.0))
    bend = np.abs(evaluate(rest + probe) - seen - jacobians @ probe).max()
    if not (np.isfinite(seen).all() and np.isfinite(jacobians).all()):
        raise SceneError(f"{named(obj)} puts vertices of '{obj.name}' at places that are not numbers. Reset it")
    space = SeenSpace(rest, seen, jacobians, False, size)
    return dataclasses.replace(space, is_affine=True) if bend <= STRAIGHT * space.reach else space


@contextlib.contextmanager
def evaluating(obj, modifiers=None, alone=False):
    """Gives a function from n x 3 of the pose's key to n x 3 float64 as seen. @throws SceneError.

    modifiers: names of those that count, else all that deform; alone: other shape keys do not."""
    evaluated, stores = _evaluated(obj, alone)
    rest = shape_keys.rest_positions(obj.data)
    former = [mesh_arrays.coordinates(store, name) for store, name, _ in stores]
    switches = np.empty(len(evaluated.modifiers), bool)
    evaluated.modifiers.foreach_get("show_viewport", switches)
    depsgraph = bpy.context.view_layer.depsgraph

    def run(shape):
        for store, name, base in stores:
            store.foreach_set(name, (base + (shape - rest)).astype(np.float32).ravel())
        mesh = evaluated.to_mesh(preserve_all_data_layers=True, depsgraph=depsgraph)
        try:
            return mesh_arrays.vertex_positions(mesh).astype(np.float64)
        finally:
            evaluated.to_mesh_clear()

    def evaluate(shape):
        found = run(shape)
        if len(found) != len(rest):
            count = f"{len(found):,} vertices of {len(rest):,}"
            raise SceneError(f"{named(obj)} shows {count}. Turn off in the viewport what makes or merges vertices")
        return found

    try:
        used = [_deforms(obj, each) if modifiers is None else each.name in modifiers for each in obj.modifiers]
        evaluated.modifiers.foreach_set("show_viewport", used)
        has_nodes = modifiers is None and any(each.type == 'NODES' for each in deformers(obj))
        if has_nodes and len(run(rest)) != len(rest):  # they make vertices, which only trying tells
            used = [each.type != 'NODES' and is_used for each, is_used in zip(obj.modifiers, used, strict=True)]
            evaluated.modifiers.foreach_set("show_viewport", used)
        yield evaluate
    finally:
        for (store, name, _), shape in zip(stores, former, strict=True):
            store.foreach_set(name, shape.ravel())
        evaluated.modifiers.foreach_set("show_viewport", switches)


def _evaluated(obj, alone):
    """(Blender's evaluated copy of the object, its stores). @throws SceneError if it has none that fits."""
    for ensure in (False, True):  # the copy may be of before the last edit
        if ensure:
            bpy.context.evaluated_depsgraph_get()
        depsgraph = bpy.context.view_layer.depsgraph
        if depsgraph is None:
            continue
        evaluated = obj.evaluated_get(depsgraph)
        stores = _stores(obj, depsgraph, alone)
        if evaluated.is_evaluated and stores is not None and len(evaluated.modifiers) == len(obj.modifiers):
            return evaluated, stores
    raise SceneError(
        f"'{obj.name}', with {named(obj)}, is not evaluated in this scene. Go to the one that has it. {views.ENABLE}"
    )


def _stores(obj, depsgraph, alone):
    """[(collection, property, n x 3 float32)]: what to displace, in Blender's evaluated copies, to displace the pose's
    key, and where each is with the pose at rest; None if the copies do not fit."""
    keys = obj.data.shape_keys
    rest = shape_keys.rest_positions(obj.data)
    if keys is None:
        mesh = obj.data.evaluated_get(depsgraph)
        fits = mesh.is_evaluated and mesh.shape_keys is None and len(mesh.vertices) == len(rest)
        return [(*compat.position_store(mesh), rest)] if fits else None
    copy = keys.evaluated_get(depsgraph)
    if not copy.is_evaluated or copy.key_blocks.keys() != keys.key_blocks.keys():
        return None
    own = _pose_keys(obj)
    shown = [key.name for key in copy.key_blocks[1:] if key.name in own and _counts(obj, key)]
    is_lone = keys.use_relative and shown == [obj.meanvalue.result_key] and not alone
    is_enough = is_lone and shape_keys.why_result_is_hidden(obj) is None
    bases = {key.relative_key.name for key in keys.key_blocks[1:] if _counts(obj, key)}  # subtracted from them
    found = []
    for key in copy.key_blocks:
        is_always_there = key == copy.reference_key or not keys.use_relative
        is_at_rest = alone or is_always_there or key.name in own
        if is_enough and key.name not in own:  # what moves the one that counts fully moves all
            continue
        if is_always_there or _counts(obj, key) or key.name in bases:
            # The scene's own key: the copy may be of before the last edit.
            shape = rest if is_at_rest else shape_keys.positions(keys.key_blocks[key.name])
            found.append((*compat.key_store(key), shape))
    return found if all(len(store) == len(rest) for store, _, _ in found) else None


def deformers(obj):
    """Modifiers, and the parent if it deforms its children as they do."""
    found = [modifier for modifier in obj.modifiers if _deforms(obj, modifier)]
    return [*found, obj.parent] if obj.parent is not None and obj.parent_type in DEFORMING_PARENTS else found


def _deforms(obj, modifier):
    baked = obj.meanvalue.baked
    is_bake = bool(baked.target) and modifier.name == baked.modifier  # plays in place of the pose
    if is_bake or pose_objects.is_ours(modifier) or not _is_on(obj, modifier) or modifier.type not in DEFORMING:
        return False
    return modifier.type != 'NODES' or not compat.simulates(modifier)


def _is_on(obj, modifier):
    return modifier.show_viewport or modifier.name in hidden(obj)


def _counts(obj, key):
    if obj.show_only_shape_key:
        return obj.active_shape_key is not None and key.name == obj.active_shape_key.name
    return not key.mute and key.value != 0.0


def _pose_keys(obj):
    """Names of the keys that are not beside the pose: what holds it, held it, or plays a bake."""
    settings = obj.meanvalue
    names = {*key_marks.pose_names(obj), *(key.name for key in key_marks.replacing(obj))}
    if settings.baked.target and settings.baked.keys:
        names.update(names_in(settings.baked.keys))
    for shown in ALL.shown_keys:
        names.update(shown.names(obj))
    return names


def shown_positions(obj):
    """n x 3 float32: where the vertices are to be seen. Modifiers count as long as they keep them, or put new ones
    behind them; else it is the result if that is shown, and the rest shape if not."""
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
