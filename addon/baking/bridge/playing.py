# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake makes in the scene, and takes back again. It plays by Blender alone, without the add-on."""

import json

import bpy
import numpy as np
from mathutils import Matrix

from ... import compat, ids, wording
from ...scene import actions, baked, declarations, key_marks, rig_space, shape_keys, vertex_groups
from ...scene.baked import TO_BONES, TO_CACHE, TO_KEYS, names_in


def play_cache(obj, path, header):
    """A Mesh Cache modifier on top of the stack."""
    modifier = obj.modifiers.new(ids.CACHE_MODIFIER, 'MESH_CACHE')
    compat.move_modifier(obj, modifier)  # it has to see the vertices of the mesh itself
    modifier.cache_format, modifier.filepath = 'PC2', path
    modifier.time_mode, modifier.play_mode = 'FRAME', 'SCENE'
    modifier.frame_scale = scale = 1.0 / header.rate
    modifier.frame_start = header.start * scale  # Blender scales the frame first
    modifier.interpolation, modifier.deform_mode = 'LINEAR', 'OVERWRITE'
    modifier.forward_axis, modifier.up_axis = 'POS_Y', 'POS_Z'
    _hide_result(obj)
    obj.meanvalue.baked.target, obj.meanvalue.baked.modifier = TO_CACHE, modifier.name


def play_keys(obj, times, shapes):
    """Shape keys at these times with their F-curves. Returns notes. For what has no keys_problem()."""
    mesh, record = obj.data, obj.meanvalue.baked
    if mesh.shape_keys is None:
        shape_keys.make_basis(obj)
    keys, active_index, made = mesh.shape_keys, obj.active_shape_key_index, []
    for time, shape in zip(times, shapes, strict=True):
        whole, dot, part = wording.frame(abs(time)).partition(".")
        name = f"Bake {'-' if time < 0 else ''}{whole.zfill(4)}{dot}{part}"  # in order by name, for frames from 0 on
        key = obj.shape_key_add(name=name, from_mix=False)
        shape_keys.write_positions(mesh, key, shape)
        key.value = 0.0
        made.append(key)
    for number, key in enumerate(made):  # at 1 at its frame, at 0 at its neighbors': they cross-fade and sum to 1
        key.mute = False
        begin, end = max(0, number - 1), min(len(made), number + 2)
        values = [float(each == number) for each in range(begin, end)]
        actions.write_curve(keys, key.path_from_id("value"), 0, times[begin:end], values, "LINEAR")
    obj.active_shape_key_index = active_index
    record.target, record.keys = TO_KEYS, json.dumps([key.name for key in made])
    _hide_result(obj)
    if obj.show_only_shape_key:
        yield "A shape key is pinned: turn off Shape Key Lock to see the bake"


def play_bones(obj, rig, to_rig, names, weights, is_seen):
    """An armature modifier and vertex groups, n x b weights. Modifiers and kept poses are off; if is_seen all keys.
    Yields notes. to_rig: from the world into its space."""
    taken = {*obj.vertex_groups.keys(), *rig.data.bones.keys()}
    former = {name: vertex_groups.unused(name, taken) for name in names if name in obj.vertex_groups}
    for name, other in former.items():
        _rename(obj, name, other)
    groups = [obj.vertex_groups.new(name=name) for name in names]
    for vertex, number in zip(*(each.tolist() for each in np.nonzero(weights)), strict=True):
        groups[number].add((vertex,), weights[vertex, number], 'REPLACE')
    record, hidden = obj.meanvalue.baked, rig_space.before_bones(obj, is_seen)
    end = obj.modifiers.find(hidden[-1].name) + 1 if hidden else 0
    shown = {each.name: (each.show_viewport, each.show_render) for each in hidden}
    record.hidden = json.dumps([(each.type, *shown.get(each.name, ())) for each in obj.modifiers[:end]])
    for each in hidden:
        each.show_viewport = each.show_render = False
    modifier = obj.modifiers.new(rig.name, 'ARMATURE')
    compat.move_modifier(obj, modifier, end)
    modifier.object, modifier.use_bone_envelopes = rig, False
    keys = obj.data.shape_keys
    _hide_result(obj, keys.key_blocks[1:] if is_seen and keys else key_marks.of_role(keys, key_marks.Role.KEPT))
    record.target, record.modifier, record.rig, record.former_groups = TO_BONES, modifier.name, rig, json.dumps(former)
    if any(each.type in rig_space.SIMULATING and each.show_viewport for each in obj.modifiers[end:]):
        yield f"'{obj.name}' is simulated on top. To have that in bones, bake to a point cache first, and keep it"
    holder = obj.parent
    if holder is None or (holder.type, obj.parent_type) != ('ARMATURE', 'OBJECT'):
        return
    if len(obj.constraints) or getattr(obj.animation_data, "action", None):
        yield f"'{obj.name}' moves by itself, and keeps its parent: glTF plays '{holder.name}'. Clear the parent first"
        return
    record.parent, record.parent_inverse = holder, json.dumps([*map(list, obj.matrix_parent_inverse)])
    obj.parent, obj.matrix_parent_inverse = rig, to_rig @ holder.matrix_world @ obj.matrix_parent_inverse


def _rename(obj, name, other):
    """Of a vertex group; modifiers and keys that it masks go on with it, of which Blender knows nothing."""
    obj.vertex_groups[name].name = other
    for each in (*obj.modifiers, *(obj.data.shape_keys.key_blocks if obj.data.shape_keys else ())):
        if getattr(each, "vertex_group", "") == name:
            each.vertex_group = other


def _remove_bones(obj, record):
    """What play_bones() has made. The armature goes with the last that it moves."""
    rig, others = record.rig, [each for each in bpy.data.objects if each.data == obj.data and each != obj]
    is_shared = any(each.meanvalue.baked.rig == rig for each in others)  # as linked duplicates have it
    for bone in rig.data.bones if rig is not None and not is_shared else ():
        if shape_keys.MADE in bone and bone.name in obj.vertex_groups:  # which are renamed with their bones
            obj.vertex_groups.remove(obj.vertex_groups[bone.name])
    for name, other in json.loads(record.former_groups or "{}").items():
        if other in obj.vertex_groups and name not in obj.vertex_groups:
            _rename(obj, other, name)
    if record.parent is not None and obj.parent == rig:
        obj.parent, obj.matrix_parent_inverse = record.parent, Matrix(json.loads(record.parent_inverse))
    moved = {getattr(modifier, "object", None) for each in bpy.data.objects for modifier in each.modifiers}
    if rig is not None and rig not in moved:
        actions.remove_action(rig)
        data = rig.data
        bpy.data.objects.remove(rig)
        if data.users == 0:
            bpy.data.armatures.remove(data)


def keys_problem(obj):
    """Why `obj` cannot be baked to shape keys, in words, or None."""
    for other in bpy.data.objects:
        if other != obj and other.data == obj.data and other.meanvalue.baked.target == TO_KEYS:
            return f"The mesh is shared with '{other.name}', whose keys play its bake. Bake to a point cache"
    return shape_keys.absolute_problem(obj)


def take_back(obj):
    """Takes back what the last bake of `obj` has made in the scene. Files stay."""
    record, keys = obj.meanvalue.baked, obj.data.shape_keys
    modifier = obj.modifiers.get(record.modifier) if record.modifier else None
    for name, shown in baked.hidden(obj).items():
        obj.modifiers[name].show_viewport, obj.modifiers[name].show_render = shown
    if modifier is not None and modifier.type in {"MESH_CACHE", "ARMATURE"}:
        obj.modifiers.remove(modifier)
    if record.target == TO_BONES:
        _remove_bones(obj, record)
    if record.target == TO_KEYS and keys is not None:
        names = names_in(record.keys)
        paths = {f'key_blocks["{bpy.utils.escape_identifier(name)}"].value' for name in names}
        keys.use_relative = True  # bakes of version 0.1 could be absolute
        curves = compat.curves_to_read(keys)
        for curve in [curve for curve in curves if curve.data_path in paths]:
            curves.remove(curve)
        if keys.animation_data is not None and keys.animation_data.action is not None and len(curves) == 0:
            actions.remove_action(keys)
        shape_keys.remove(obj, names)
    muted = json.loads(record.muted or "[]")
    values = muted if isinstance(muted, dict) else {}  # in older files, where values stayed
    for name in muted if obj.data.shape_keys is not None else ():
        key = obj.data.shape_keys.key_blocks.get(name) if name else shape_keys.result(obj)
        if key is not None:
            key_marks.show(key, values.get(name, key.value))
    was_live, was_mixed, kind = record.was_live, record.was_mixed, baked.source(obj)
    declarations.clear(record)
    if was_live:
        obj.meanvalue.live = True
    if was_mixed and kind is not None:
        kind.turn(obj, True)


def keep(obj):
    """What the last bake has made stays, and is the add-on's no more."""
    record, keys = obj.meanvalue.baked, obj.data.shape_keys
    obj.meanvalue.live = False
    key = shape_keys.result(obj)
    if key is not None and {"", key.name}.intersection(names_in(record.muted)) and keys.use_relative:
        shape_keys.remove(obj, [key.name])
    declarations.clear(record)


def _hide_result(obj, more=()):
    """The mesh must not be moved twice: what poses it is muted, and `more` keys, and what follows at once ends."""
    record, settings, kind = obj.meanvalue.baked, obj.meanvalue, baked.source(obj)
    record.was_live, record.was_mixed = settings.live, kind is not None and kind.is_on(obj)
    shown = kind.shown_keys(obj) if record.was_mixed else []
    settings.live = False
    if record.was_mixed:
        kind.turn(obj, False)
    key = shape_keys.result(obj)
    named = {each.name: each for each in [*shown, *more] if each.name not in names_in(record.keys)}
    if key is not None and key != key.id_data.reference_key and key.name not in named:
        named[""] = key  # known by its mark, whatever it is called by then
    named = {name: each for name, each in named.items() if not each.mute}
    record.muted = json.dumps({name: each.value for name, each in named.items()})
    for each in named.values():
        key_marks.show(each, None)
