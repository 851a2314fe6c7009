# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones and weights that stand for what moves a mesh, and what goes along with it: one armature for all."""

import itertools
import json
import math

import bpy
import numpy as np
from mathutils import Matrix

from ... import wording
from ...errors import SceneError
from ...scene import actions, frames, mesh_arrays, pose_objects, rig_space, shape_keys, vertex_groups, views, worn
from ...scene.baked import source
from ...scene.core import motion
from ...scene.core.point_sets import bounding_box_diagonal
from ...solver import native_loader, session
from . import playing

#: Exporters leave out such weights: without them a vertex moves by less than bones are off.
LEAST_WEIGHT = 1e-3

REFUSED = "No bones can be found: {}"


def is_seen(obj):
    """Whether neither handles nor a mix move a mesh, but what bones alone can stand for. Cheap."""
    keys = obj.data.shape_keys
    is_moved = rig_space.before_bones(obj) or (keys is not None and actions.is_animated(keys))
    return bool(is_moved) and not (obj.meanvalue.handles or source(obj))


def problem(obj):
    """Why bones cannot stand for what moves `obj`, in words, or None."""
    if pose_objects.shown(obj) != obj:
        return f"'{obj.parent.name}' is of another file, and takes no weights. Bake to a point cache"
    if obj.parent is not None and obj.parent_type in rig_space.DEFORMING_PARENTS:
        return f"'{obj.parent.name}' deforms '{obj.name}' as its parent. Parent it as Object, and add a modifier"
    is_small = bounding_box_diagonal(shape_keys.rest_positions(obj.data)) < 1e-4  # Blender drops bones below 1e-6
    settings = obj.meanvalue
    rig, record = settings.bake.armature, settings.baked
    names = {bone.name for bone in _deforming(rig)} if rig else set()
    if record.rig and (record.rig == rig or record.former_groups not in {"", "{}"}):
        return f"'{obj.name}' is baked with such bones. Press Remove Bake first"
    if shape_keys.sharing(obj) and names.intersection(obj.vertex_groups.keys()):
        return f"'{obj.name}' shares its mesh, which has groups named as bones of '{rig.name}'. Make it single-user"
    if rig and not names:
        return f"'{rig.name}' has no bones that deform. Tick Deform of some"
    if same := names.intersection([*settings.handles.keys(), settings.roi_group]):
        return f"{wording.quoted(sorted(same))} of '{obj.name}' has the name of a bone of '{rig.name}'. Rename it"
    return f"'{obj.name}' is too small for bones. Scale it up" if is_small else shape_keys.absolute_problem(obj)


def _deforming(rig):
    return [bone for bone in rig.data.bones if bone.use_deform]


def _given(rig, ways, poses):
    """An armature for the solver: that which was chosen, in the space of the mesh. ways: f x 4 x 4, from there to its
    own; poses: f x b x 4 x 4 of its bones, or none. @throws SceneError."""
    bones, back = _deforming(rig), np.linalg.inv(ways)
    heads = motion.apply(back[0], np.array([bone.head_local for bone in bones]))
    tails = motion.apply(back[0], np.array([bone.tail_local for bone in bones]))
    parents = [next((bones.index(each) for each in bone.parent_recursive if each in bones), -1) for bone in bones]
    rests = np.array([bone.matrix_local for bone in bones], np.float64)
    moved = back[:, None] @ poses @ np.linalg.inv(rests) @ ways[:, None] if len(poses) else None
    return heads, tails, parents, moved


def fit(parts, shapes, times, is_seen, options):
    """Generator of the share done; returns (a native BoneFit of all parts in the space of the first, where that is).

    parts: the mesh, and what goes along; shapes: for each f of n x 3 float32, without modifiers; is_seen: at rest,
    since not handles move the mesh. @throws MeanValueError."""
    modifiers, obj, worlds = [rig_space.before_bones(part, is_seen) for part in parts], parts[0], []
    begins = [each.point_cache.frame_start for each in itertools.chain(*modifiers) if each.type in rig_space.SIMULATING]
    ahead = range(min(begins, default=1 << 20), math.ceil(times[0]))  # simulations know a frame from the one before
    modifiers, ahead_of = [[each.name for each in group] for group in modifiers], iter(ahead)
    rig, ways, poses = obj.meanvalue.bake.armature, [], []

    def see():
        if next(ahead_of, None) is not None:
            return
        row = len(worlds)
        worlds.append(np.array(obj.matrix_world, np.float64))
        ways.append(np.eye(4) if rig is None else np.linalg.inv(np.array(rig.matrix_world, np.float64)) @ worlds[-1])
        poses.append(rig and np.array([rig.pose.bones[bone.name].matrix for bone in _deforming(rig)]))
        for part, names, own in zip(parts, modifiers, shapes, strict=True):
            with rig_space.evaluating(part, names, alone=not is_seen) as evaluate:
                own[row] = evaluate(own[row]).astype(np.float32)

    yield from frames.visit(bpy.context.scene, [*ahead, *times], see)
    axes = np.array(worlds if rig is None else ways[: None if options.its_motion else 1])[:, :3, :3]
    grams = np.swapaxes(axes, 1, 2) @ axes  # the same where it turns and moves alone, diagonal where nothing is oblique
    wanted = np.diag(np.diag(grams[0])) if rig is None else grams[0, 0, 0] * np.eye(3)
    if np.abs(grams - wanted).max() > 1e-3 * grams.max():
        remedy = "Keep its scale still, and that of its parents even" if rig is None else f"Apply that of '{rig.name}'"
        raise SceneError(f"'{obj.name}' grows, or is scaled unevenly, which bones cannot show. {remedy}")
    places = [worn.to_carrier(obj, each) for each in parts]
    rests = [shape_keys.rest_positions(each.data) for each in parts]
    rest, *rows = (
        np.concatenate([motion.apply(*each) for each in zip(places, row, strict=True)]).astype(np.float32)
        for row in [rests, *zip(*shapes, strict=True)]
    )
    execution, size = native_loader.module().Execution(), bounding_box_diagonal(rests[0])
    places = zip(parts, rests, itertools.accumulate(map(len, rests), initial=0), strict=False)
    task = session.call(
        native_loader.module().start_fit_bones,
        *(rest, rows),
        faces=np.concatenate([mesh_arrays.triangles(part.data, own) + start for part, own, start in places]),
        count=options.bones or 20,
        error=None if options.bones else max(options.tolerance_share, 1e-3) / 100.0 * size,
        influences=options.influences,
        joints=options.skeleton,
        armature=None if rig is None else _given(rig, np.array(ways), np.array(poses if options.its_motion else [])),
        execution=execution,
        refused=REFUSED,
    )
    try:
        while not task.finished:
            task.wait(0.02)
            yield execution.progress
        return session.call(task.result, refused=REFUSED), worlds, ways[0]
    finally:
        execution.cancel()


def play(parts, found, worlds, way, times, is_seen, options):
    """Has the bones found play in the parts, as of fit(). Returns (what was made, how near it is, notes), in words."""
    obj, rig = parts[0], parts[0].meanvalue.bake.armature
    taken = {each.name for part in parts for each in part.vertex_groups}
    to_rig = Matrix(way) @ obj.matrix_world.inverted()  # with parents where they are now
    names = [f"Bone {number:02}" for number in range(1, len(found.parents) + 1)]
    names = [bone.name for bone in _deforming(rig)] if rig else [vertex_groups.unused(name, taken) for name in names]
    root = [vertex_groups.unused("Root", taken)] if options.root_bone and rig is None else []
    rig = _rig(obj, found, root + names, way, times)
    if np.ptp(worlds, axis=0).any():
        actions.write_motion(rig, times, worlds @ np.linalg.inv(way))
    weights = np.where(found.weights < LEAST_WEIGHT, 0.0, found.weights)
    off = found.errors.astype(np.float64) / bounding_box_diagonal(shape_keys.rest_positions(parts[0].data))
    notes, ends = [], np.cumsum([len(each.data.vertices) for each in parts[:-1]])
    weights, worst = np.split(weights / weights.sum(axis=1, keepdims=True), ends), off.max(axis=1).argmax()
    for part, own, far in zip(parts, weights, np.split(off[worst], ends), strict=True):
        notes += playing.play_bones(part, rig, to_rig, names, own, is_seen)
        part.meanvalue.baked.worst = json.dumps([times[worst], np.flatnonzero(far > 0.5 * off.max()).tolist()])
    rms, at = np.sqrt((off**2).mean()), wording.frame(times[worst])
    near = f"rms {rms:.2%}, largest {off.max():.2%} of the size, at frame {at}"
    if off.max() > 0.02:
        notes.append("Bones turn and move: what grows, or flies apart, stays off. Select Worst Vertices shows where")
    if not np.allclose(parts[0].matrix_world.to_scale(), 1.0, atol=1e-4):
        notes.append(f"'{parts[0].name}' has a scale: apply it before export (Object > Apply > Scale)")
    return wording.counted(len(names), "bone"), near, notes


def _rig(obj, found, names, way, times):
    """An armature object with an action at these times, of the bones found, or a copy of the one that was chosen.
    way: from the space of `obj` to its own."""
    heads, tails, parents, chosen = found.heads, found.tails, found.parents, obj.meanvalue.bake.armature
    transforms, back = way @ found.transforms @ np.linalg.inv(way), Matrix(np.linalg.inv(way))
    if len(names) > len(heads):  # the first goes along the ground as the first one found does
        up, line = motion.unit(np.array(obj.matrix_world.inverted())[:3, 2]), transforms[:, 0, :3] @ [*heads[0], 1.0]
        root = np.tile(np.eye(4), (len(line), 1, 1, 1))
        root[:, 0, :3, 3] = (line - heads[0]) @ (np.eye(3) - np.outer(up, up))
        heads, tails = [0.0 * up, *heads], [np.linalg.norm(tails[0] - heads[0]) * up, *tails]
        parents, transforms = [-1, *(parents + 1)], np.concatenate([root, transforms], axis=1)
    data, layer = chosen.data.copy() if chosen else bpy.data.armatures.new("Armature"), bpy.context.view_layer
    rig = bpy.data.objects.new(f"{obj.name} Armature", data)
    data.name, data.pose_position = rig.name, 'POSE'
    data.animation_data_clear()  # of what was copied
    bpy.context.scene.collection.objects.link(rig)  # others may be hidden, where nothing has an Edit Mode
    views.show_in_local_views(rig, obj)
    rig.matrix_world, rig.show_in_front = obj.matrix_world @ back, True
    active, layer.objects.active = layer.objects.active, rig
    bpy.ops.object.mode_set(mode='EDIT')
    bones = [data.edit_bones.get(name) or data.edit_bones.new(name) for name in names]
    for bone in data.edit_bones:
        bone.use_inherit_rotation = bone.use_local_location = True
        bone.use_connect = bone.use_connect and bone.parent.use_deform  # those without Deform stay at rest
        bone.bbone_segments = 1  # weights were found for bones that do not bend
    for bone, head, tail, parent in zip(bones, heads, tails, parents, strict=True) if chosen is None else ():
        bone.head, bone.tail, bone.parent = head, tail, bones[parent] if parent >= 0 else None
    bpy.ops.object.mode_set(mode='OBJECT')
    layer.objects.active = active
    still = 1e-6 * np.ptp([*heads, *tails], axis=0).max()  # joints move less, by rounding, and get no keys of that
    for name, moved, parent in zip(names, transforms.swapaxes(0, 1), parents, strict=True):
        data.bones[name][shape_keys.MADE] = True
        of_parent = np.linalg.inv(transforms[:, parent]) if parent >= 0 else np.eye(4)
        rest = np.array(data.bones[name].matrix_local, np.float64)
        own = np.linalg.inv(rest) @ of_parent @ moved @ rest
        actions.write_motion(rig.pose.bones[name], times, own, moves=np.abs(own[:, :3, 3]).max() > still)
    return rig
