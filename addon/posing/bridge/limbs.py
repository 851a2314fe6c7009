# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a mesh bends (Bend At): from its rig's weights, its kept poses or a painted group to how much lengths count."""

import collections

import numpy as np
from mathutils import Matrix

from ... import compat, ids, wording
from ...scene import kept, key_marks, shape_keys, vertex_groups
from ...scene.key_marks import Role
from ..core import joints, segments

#: Kept poses that tell where a mesh bends: what no pose bends is stiff. How many times as far as to the end of a limb
#: surroundings go, which follow the less the farther they are. So many vertices say where a handle is.
LEAST_POSES, BEYOND, SAMPLES = 2, 1.1, 50


def choose(obj):
    """A handle is to be made: a mesh that has none yet bends at its rig's joints, unless somebody chose."""
    settings = obj.meanvalue
    if not (settings.handles or settings.is_property_set("bend_at")) and _weighted_bones(obj):
        settings.bend_at = ids.BEND_RIG


def least(obj, vertex, length):
    """How long the limb that a press on `vertex` means is at least: so long, or up to where one begins that is."""
    return max(length, next((way for _top, way in _limbs_up(obj, [vertex]) if way >= length), 0.0))


def up_to_body(obj, vertex, length):
    """How far the surroundings of a press on `vertex` go that would go so far, in the mesh's space: from half way on to
    where its limb begins, and if beyond a knee or an elbow of its rig, to where that ends."""
    ways, parents, places = _limbs_up(obj, [vertex]), _parents(obj), _places(obj)
    length = max(length, *(BEYOND * way for _top, way in ways[:1] if way < 2.0 * length), 0.0)
    uppers = {lower: upper for upper, lower, _ends in segments.hinges(parents, segments.of(parents))}
    passed = [(way, places[top], places[uppers[top]]) for top, way in ways if top in uppers and way < length]
    return max([length, *(BEYOND * (way + np.linalg.norm(upper - lower)) for way, lower, upper in passed)])


def riding(obj, vertices, length):
    """n float64, 0 to 1: how much of the last limb up to whose begin the surroundings of `vertices` go, and of all that
    hangs on it: that goes along, as bones do."""
    total, found = np.zeros((2, len(obj.data.vertices)))
    top = next((top for top, way in reversed(_limbs_up(obj, vertices)) if way <= length), "")
    if not top:
        return found
    parents = _parents(obj)
    of_bone = segments.of(parents)
    for bone, (numbers, weights) in vertex_groups.read(obj, sorted(_weighted_bones(obj))).items():
        total[numbers] += weights
        if of_bone[top] in map(of_bone.get, (bone, *segments.above_of(bone, parents))):
            found[numbers] += weights
    return found / np.where(total > 0.0, total, 1.0)


def one_piece(obj, vertices):
    """Of `vertices` those that move as one, as bones do: what is of one limb with most of them, or hangs on that."""
    ways = _limbs_up(obj, vertices)
    return vertices[riding(obj, vertices, ways[0][1])[vertices] > 0.5] if ways else vertices


def _limbs_up(obj, vertices):
    """[(first bone of a limb, how far that begins from `vertices`)] from what has most of them up to the body, which is
    no limb; none if it does not bend there."""
    is_at_rig, bones = obj.meanvalue.bend_at == ids.BEND_RIG or not obj.meanvalue.handles, _weighted_bones(obj)
    tops = segments.tops_up(most_of(obj, shares(obj, vertices)) if is_at_rig else "", _parents(obj), bones)
    if not tops:
        return []  # the mesh may be large
    middle, places = shape_keys.rest_positions(obj.data)[vertices].mean(axis=0), _places(obj)
    return [(top, np.linalg.norm(places[top] - middle)) for top in tops]


def shares(obj, vertices):
    """{name of a vertex group: its weight} of some of the vertices."""
    names, found = dict(enumerate(obj.vertex_groups.keys())), collections.Counter()
    chosen = (obj.data.vertices[int(vertex)] for vertex in vertices[:: 1 + len(vertices) // SAMPLES])
    for each in (element for vertex in chosen for element in vertex.groups):
        found[names.get(each.group, "")] += each.weight  # scripts leave weights of no group
    return found


def most_of(obj, weights):
    """The deepest bone that carries, with those below it, more than half of the weights as of shares(): a hand, not one
    of its fingers; "" without bones."""
    bones, parents, carried = _weighted_bones(obj), _parents(obj), collections.Counter()
    for bone in filter(bones.__contains__, weights):
        carried.update(dict.fromkeys([bone, *segments.above_of(bone, parents)], weights[bone]))
    deep = [bone for bone, weight in carried.items() if 2.0 * weight > max(carried.values())]  # one below the other
    return min(deep, key=carried.get, default="")


def signature(obj):
    """What is quick to compare of all that read() reads beside the mesh, its groups and the settings."""
    if obj.meanvalue.bend_at == ids.BEND_RIG:
        return tuple((compat.session_key(rig.data), *_quickly(rig.data.bones, obj, rig)) for rig in _rigs(obj))
    return _kept_poses(obj) if obj.meanvalue.bend_at == ids.BEND_POSES else ()


def groups(obj):
    """Names of the vertex groups that read() reads."""
    if obj.meanvalue.bend_at == ids.BEND_RIG:
        return _weighted_bones(obj)
    return {obj.meanvalue.stiffness_group} if obj.meanvalue.bend_at == ids.BEND_PAINTED else ()


def read(obj, rest, corners, starts):
    """What of a BindInput tells where it bends: all by their names, as far as there is anything to tell."""
    if obj.meanvalue.bend_at == ids.BEND_RIG:
        return _at_rig(obj, rest, corners, starts)
    if obj.meanvalue.bend_at == ids.BEND_POSES:
        return _at_poses(obj, rest, corners, starts)
    painted = [*vertex_groups.weights(obj, groups(obj)).values()]
    return {"stiffness": 1.0 + (joints.STIFF - 1.0) * painted[0]} if painted else {}


def _at_rig(obj, rest, corners, starts):
    bones, parents = _weighted_bones(obj), _parents(obj)
    weights = vertex_groups.read(obj, bones)
    of_bone, found = segments.of(parents), {}
    for bone in sorted(bones):
        if len(weights[bone][0]):
            found.setdefault(of_bone[bone], []).append(weights[bone])
    if not found:
        return {"bends": "No bone of a rig has weights here: it bends everywhere"}
    factors, *parts = joints.by_weights(rest.astype(np.float64), found, _hinges(obj, parents, of_bone, found))
    up = segments.ways_up(parents, of_bone, found)
    told = wording.counted(sum(len(way) > 1 for way in up), "joint")
    bends = f"Bends at {told} of {wording.quoted([rig.name for rig in _rigs(obj)])}"
    return {"stiffness": factors, "limbs": joints.limbs(rest, corners, starts, *parts, up), "bends": bends}


def _hinges(obj, parents, of_bone, found):
    """Of knees and elbows, as of joints.by_weights()."""
    places, feet = _places(obj), []
    for rig in _rigs(obj):
        to_mesh = _to_mesh(obj, rig).to_3x3()
        for bone in filter(lambda bone: segments.is_foot(bone.name), rig.data.bones):
            toe = bone.children[0].head_local if bone.children else bone.tail_local
            feet.append(to_mesh @ (toe - bone.head_local))
    forward, hinges = np.sum(feet, axis=0) if feet else None, []
    for upper, lower, ends in segments.hinges(parents, of_bone):
        end = max(ends, key=lambda each: np.linalg.norm(places[each] - places[lower]))  # others help at the joint
        way = forward if forward is None or not segments.is_arm(lower) else -forward
        told = joints.hinge(places[upper], places[lower], places[end], way)
        if told is not None and {of_bone[upper], of_bone[lower]} <= found.keys():
            hinges.append((of_bone[upper], of_bone[lower], *told))
    return hinges


def _at_poses(obj, rest, corners, starts):
    keys = _kept_poses(obj)
    if len(keys) < LEAST_POSES:
        return {"bends": f"Keep {LEAST_POSES} poses that bend its joints: until then it bends everywhere"}
    shapes = vertex_groups.shapes_of(obj, keys).with_effect()
    inputs = rest, *shapes.points.values()
    found = kept.of(obj.data, "limbs", lambda: joints.by_poses(rest, corners, starts, shapes.shapes()), *inputs)
    if found.min(initial=joints.STIFF) > 0.5 * joints.STIFF:
        bends = "No kept pose bends it more in one place than in others: it bends everywhere"
        return {"kept_poses": shapes, "bends": bends}
    return {"stiffness": found, "kept_poses": shapes, "bends": f"Bends as {wording.counted(len(keys), 'kept pose')} do"}


def _quickly(bones, obj, rig):
    """Where bones are, in the rig and seen from their parents, which deform, and how the rig is turned to the mesh."""
    places, deforms = np.empty((2, 3 * len(bones)), np.float32), np.empty(len(bones), bool)
    bones.foreach_get("head_local", places[0])
    bones.foreach_get("head", places[1])
    bones.foreach_get("use_deform", deforms)
    return places.tobytes(), deforms.tobytes(), np.array(_to_mesh(obj, rig))[:3, :3].round(4).ravel().tolist()


def _parents(obj):
    """{bone: its parent, or ""} of the rigs."""
    return {bone.name: bone.parent.name if bone.parent else "" for rig in _rigs(obj) for bone in rig.data.bones}


def _places(obj):
    """{bone: (3,) where it begins at rest, in the mesh's space}."""
    rigs = [(_to_mesh(obj, rig), rig.data.bones) for rig in _rigs(obj)]
    return {bone.name: np.array(matrix @ bone.head_local) for matrix, bones in rigs for bone in bones}


def _to_mesh(obj, rig):
    """The matrix from `rig` to `obj` by their settings below what both hang on, however that moves."""
    from_mesh, from_rig = _above(obj), _above(rig)
    shared = next(each for each in from_rig if each in from_mesh)
    return from_mesh[shared].inverted_safe() @ from_rig[shared]


def _above(obj):
    """{obj and what it hangs on, at last None for the world: the matrix from `obj` to there}."""
    found, matrix = {}, Matrix()
    while obj is not None:
        found[obj] = matrix
        obj, matrix = obj.parent, obj.matrix_parent_inverse @ obj.matrix_basis @ matrix
    return {**found, None: matrix}


def _kept_poses(obj):
    return [vertex_groups.slider_of(obj, key) for key in key_marks.of_role(obj.data.shape_keys, Role.KEPT)]


def _rigs(obj):
    """The armatures whose bones move the object by its vertex groups, each once."""
    own = [each for each in obj.modifiers if each.type == 'ARMATURE' and each.name != obj.meanvalue.baked.modifier]
    found = [each.object for each in own if each.use_vertex_groups]
    found += [obj.parent] if obj.parent_type == 'ARMATURE' else []
    return list(dict.fromkeys(rig for rig in found if rig is not None and rig.type == 'ARMATURE'))


def _weighted_bones(obj):
    """Names of the bones that deform, and have a vertex group."""
    bones = {bone.name for rig in _rigs(obj) for bone in rig.data.bones if bone.use_deform}
    return bones.intersection(obj.vertex_groups.keys())
