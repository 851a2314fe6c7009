# SPDX-License-Identifier: GPL-3.0-or-later
"""The poses of bones that shape keys are for, stored with them; and keys for the other side."""

import contextlib
import itertools
import re
import zlib

import bpy
import numpy as np
from mathutils import Matrix, Quaternion, Vector

from ...errors import SceneError
from ...live import engine
from ...scene import actions, along, key_marks, mesh_arrays, mirrors, rig_space, shape_keys, vertex_groups
from ...scene.core.point_sets import bounding_box_diagonal
from ...scene.key_marks import Role
from ...scene.surface import Surface

#: On the datablock of the keys: {mark of a key: {bone: its turn}}; on the object: what a muted driver is of.
POSES, BONES = "meanvalue_poses", "meanvalue_bones"

#: On the datablock of the keys, of what goes along too: {mark of the mesh's key: {"rig": {bone: 16 numbers, what it
#: does of itself}, "seen": n x 3 float32 where the key alone was seen, "own": n x 3 float32 what it added then, "off":
#: share of the size when checked last}}. Of the size: from where on a key is off, and is brought nearer.
SHOWN, OFF, NEAR = "meanvalue_shown", 1e-4, 2e-6
CHANNELS = "location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale"

#: The sine of 0.3 degrees: a bone that is turned by less than twice that is not posed. Of the size of the rig: how near
#: a bone is to the image of the one across.
LEAST_TURN, SAME_PLACE = 0.005, 1e-3

_OURS = re.compile(r"u\d+/\(u0(\+u\d+)*\)")


def is_driven(key):
    """Whether its driver is one of ours."""
    curve = actions.driver_of(key)
    return bool(curve and _OURS.fullmatch(curve.driver.expression))


def is_free(key):
    """Whether neither a driver nor keyframes of an artist's move it."""
    keyframes, _values = actions.read_keys(key.id_data, key.path_from_id("value"))
    return is_driven(key) or not (actions.driver_of(key) or len(keyframes))


def turns_now(obj, key):
    """{bone: Quaternion} of the bones that are turned and carry what `key` moves; of all if none does."""
    rig, found = rig_space.armature(obj), {}
    for bone in rig.pose.bones if rig is not None else ():
        local = rig.convert_space(pose_bone=bone, matrix=bone.matrix, from_space='POSE', to_space='LOCAL')
        turn = local.to_quaternion().normalized()
        if Vector(turn[1:]).length >= LEAST_TURN:
            found[bone.name] = turn
    squares = np.square(shape_keys.positions(key) - shape_keys.rest_positions(obj.data)).sum(axis=1)
    moved = squares > 0.01 * squares.max(initial=0.0)
    carry = [name for name, members in vertex_groups.members(obj, found).items() if moved[members].any()]
    return {name: found[name] for name in carry or found}


def store(obj, key, turns):
    """Gives the key its pose, and a mark by which that is found; an artist's key does not pass for one just kept."""
    taken = [each.slider_min for each in key.id_data.key_blocks if each != key]
    if key_marks.role(key) is None or (key_marks.role(key) == Role.KEPT and key.slider_min in taken):
        counts = itertools.count(int(key_marks.role(key) is None))
        marks = (key_marks.mark(Role.KEPT, key.name + " " * count) for count in counts)
        key.slider_min = next(mark for mark in marks if mark not in taken)
    follow_bones(obj, {repr(key.slider_min): {name: list(turn) for name, turn in turns.items()}})


def follow_bones(obj, new=()):
    """Stored poses have bones by the names of now, and `new` ones are added. Blender renames bones in drivers: so a
    muted driver has all that are stored as variables."""
    keys, rig, names = obj.data.shape_keys, rig_space.armature(obj), {}
    for owner in (*key_marks.sharing(obj), obj):
        curve = owner.animation_data and owner.animation_data.drivers.find(f'["{BONES}"]')
        names |= {each.name: each.targets[0].bone_target for each in curve.driver.variables} if curve else {}

    def of_now(pose):
        return {names.get(_variable(bone), bone): numbers for bone, numbers in pose.items()}

    marks, new = {repr(each.slider_min) for each in keys.key_blocks}, dict(new)
    poses, known = (keys[each].to_dict() if each in keys else {} for each in (POSES, SHOWN))
    keys[POSES] = {mark: of_now(pose) for mark, pose in poses.items() if mark in marks} | new
    keys[SHOWN] = {
        mark: each | {"rig": of_now(each["rig"])} for mark, each in known.items() if mark in marks - new.keys()
    }
    bones = {*itertools.chain(*keys[POSES].values(), *(each["rig"] for each in keys[SHOWN].values()))}
    if rig is not None and any(names.get(_variable(bone)) != bone for bone in bones):
        obj[BONES] = 0.0
        obj.driver_remove(f'["{BONES}"]')
        variables = {_variable(bone): (rig, bone, "ROT_W", 'QUATERNION') for bone in bones}
        actions.drive(obj, variables, "0", f'["{BONES}"]').mute = True


def _variable(bone):
    return f"b{zlib.crc32(bone.encode()):08x}"


def pose_of(key, rig=None):
    """{bone: Quaternion} that the key is for; empty if that is not known, or of bones that `rig` has no more."""
    pose = key.id_data.get(POSES, {}).get(repr(key.slider_min), {})
    found = {name: Quaternion(turn) for name, turn in pose.items()}
    return found if rig is None or all(name in rig.pose.bones for name in found) else {}


def note_shown(obj, key):
    """What the key and what goes along show alone with the rig as it is, which is its pose, they are to show there."""
    bones = rig_space.armature(obj).pose.bones
    posed = {each.name: [*itertools.chain(*each.matrix_basis)] for each in bones if each.matrix_basis != Matrix()}
    for other, own in along.keys_of(obj, key):
        with contextlib.suppress(SceneError), rig_space.evaluating(other, alone=True) as evaluate:
            seen = evaluate(_alone(other, own)).astype(np.float32).tobytes()
            own.id_data[SHOWN] = own.id_data.get(SHOWN, {})
            known = {"rig": posed, "seen": seen, "own": _added(own).tobytes(), "off": 0.0}
            own.id_data[SHOWN][repr(key.slider_min)] = known
    follow_bones(obj)


def _added(key):
    return (shape_keys.positions(key) - shape_keys.positions(key.relative_key)).astype(np.float32)


def _is_edited(key, mark):
    """Whether an artist has changed what the key adds since it was noted; edits of the Basis are none."""
    noted = np.frombuffer(key.id_data.get(SHOWN, {}).get(mark, {}).get("own", b""), np.float32).reshape(-1, 3)
    added = _added(key)
    size = bounding_box_diagonal(shape_keys.positions(key.relative_key))
    return len(noted) == len(added) and np.abs(added - noted).max(initial=0.0) > NEAR * size


def off_by(key):
    """How far the key was from what it is to show when that was checked last, as a share of the size."""
    return key.id_data.get(SHOWN, {}).get(repr(key.slider_min), {"off": 0.0})["off"]


def _alone(obj, key):
    """n x 3 float64: the rest shape with what the key adds."""
    return next(vertex_groups.shapes_of(obj, [vertex_groups.slider_of(obj, key)]).shapes())


def refresh(obj, keys, writes):
    """Returns ({name: (how far a kept pose is from what it showed, and how far then)}, shares of the size; names of
    those that were edited since). writes: the others are brought there, with what goes along. Those of which that is
    not known are left out. @throws SceneError."""
    rig, found, edited = rig_space.armature(obj), {}, []
    if obj.meanvalue.baked.former_groups not in {"", "{}"}:
        raise SceneError(f"The bake to bones has other weights in '{obj.name}'. Press Remove Bake first")
    own = [each for each in obj.modifiers if each.type == 'ARMATURE' and each.object == rig]
    if rig.data.pose_position == 'REST' or (own and not any(each in own for each in rig_space.deformers(obj))):
        raise SceneError(f"'{rig.name}' does not pose '{obj.name}' now. Turn on its modifier, and Pose Position")
    bones = rig.pose.bones
    known = {key: obj.data.shape_keys.get(SHOWN, {}).get(repr(key.slider_min)) for key in keys}
    with engine.held(), contextlib.ExitStack() as after:  # nothing follows, and the rig is as it was afterwards
        after.callback(bpy.context.view_layer.update)
        for bone, path in itertools.product(bones, CHANNELS):
            after.callback(setattr, bone, path, tuple(getattr(bone, path)))
        for key in filter(known.get, keys):
            for bone in bones:
                bone.matrix_basis = Matrix(np.reshape(known[key]["rig"].get(bone.name, np.eye(4)), (4, 4)))
            bpy.context.view_layer.update()
            mark, parts = repr(key.slider_min), along.keys_of(obj, key)
            edited += [key.name] * any(_is_edited(own, mark) for _, own in parts)
            offs = [_refresh(*each, mark, writes and key.name not in edited) for each in parts]
            if any(offs):
                found[key.name] = tuple(map(max, zip(*filter(None, offs), strict=True)))
                known[key]["off"] = found[key.name][1]
    return found, edited


def _refresh(obj, key, mark, writes):
    known = key.id_data.get(SHOWN, {}).get(mark, {"seen": b""})
    seen = np.frombuffer(known["seen"], np.float32).reshape(-1, 3).astype(np.float64)
    if len(seen) != len(obj.data.vertices):
        return None
    size, shape = bounding_box_diagonal(seen), _alone(obj, key)
    with rig_space.evaluating(obj, alone=True) as evaluate:
        off = then = np.abs(evaluate(shape) - seen).max(initial=0.0) / size
        if writes and off > NEAR:
            space, found = rig_space.measured(obj, evaluate), shape.copy()
            moved = np.flatnonzero(~space.is_flat)
            found[moved] = space.in_key(moved, seen[moved], evaluate)
            then = np.abs(evaluate(found) - seen).max(initial=0.0) / size
    if then < off:
        mask = vertex_groups.weights(obj, {key.vertex_group}).get(key.vertex_group, np.ones(len(seen)))[:, None]
        own = shape_keys.positions(key) + (found - shape) / np.where(mask > 1e-3, mask, np.inf)
        shape_keys.write_positions(obj.data, key, own.astype(np.float32))
        known["own"] = _added(key).tobytes()
    return off, min(off, then)


def pose_rig(rig, keys, key):
    """Turns the bones that `keys` are for to the pose of one of these. Returns what it did. @throws SceneError."""
    pose = pose_of(key, rig) if rig is not None else {}
    if not pose:
        raise SceneError(f"The pose for '{key.name}' is not known. Pose the rig and press Drive by Pose")
    for bone in (rig.pose.bones[name] for name in set().union(*map(pose_of, keys)) if name in rig.pose.bones):
        place, _turn, scale = bone.matrix_basis.decompose()
        bone.matrix_basis = Matrix.LocRotScale(place, pose.get(bone.name, Quaternion()), scale)
    return f"The rig is posed as for '{key.name}'"


def mirror(obj, keys):
    """Keys for the other side by their names, written anew if they are there, with their poses. Returns ({key: its
    pair}, names of bones that none is across from, how many vertices have no mirror image, names of keys of what goes
    along that an artist moves)."""
    pairs, alone, lost, taken = {}, set(), 0, []
    for key in keys:
        pairs[key], missing = _mirrored(obj, key)
        for _, own in along.keys_of(obj, pairs[key]):  # it shows something else now, which refresh() is to leave
            own.id_data.get(SHOWN, {}).pop(repr(pairs[key].slider_min), None)
        lost = max(lost, missing)
        for other, own in along.keys_of(obj, key)[1:]:
            name = bpy.utils.flip_name(own.name)
            there = own.id_data.key_blocks.get(name)
            if there is not None and (other, there) not in along.keys_of(obj, pairs[key]):
                taken.append(name)  # an artist's
            elif name != own.name:
                pair = _mirrored(other, own)[0]
                if is_free(pair):
                    along.drive(pair, pairs[key])
        pose = pose_of(key)
        images = _images(obj, pose) if rig_space.armature(obj) is not None else {}
        alone.update(pose.keys() - images)
        if images:
            store(obj, pairs[key], dict(images.values()))
    return pairs, sorted(alone), lost, taken


def _across(obj):
    """3 x 3: over the plane of Symmetric, or else of X."""
    axis = 'X' if obj.meanvalue.symmetric == 'NONE' else obj.meanvalue.symmetric
    return Matrix.Diagonal([1.0 - 2.0 * (axis == each) for each in "XYZ"])


def _mirrored(obj, key):
    """(the key for the other side, made or written anew; how many vertices have no mirror image)."""
    flip, keys, relative = bpy.utils.flip_name, key.id_data.key_blocks, key.relative_key
    rest, across = shape_keys.rest_positions(obj.data), np.array(_across(obj))
    twins = mirrors.partners(obj, rest, (*np.diag(across < 0.0).astype(float), 0.0))
    offsets, lost = _alone(obj, key) - rest, np.flatnonzero(twins < 0)  # what masks it is part of its shape
    moved = offsets[twins]
    if len(lost):
        surface = Surface(rest, mesh_arrays.triangles(obj.data, rest))
        face, shares, *_ = surface.nearest(rest[lost] @ across, surface.normals()[lost] @ across)
        there = np.einsum("kc,kcj->kj", shares, offsets[surface.triangles[np.maximum(face, 0)]])
        moved[lost] = np.where(face[:, None] < 0, 0.0, there)
    pair, relative = keys.get(flip(key.name)), keys.get(flip(relative.name), relative)
    if pair is None:
        pair = shape_keys.add_shape(obj, flip(key.name), None)
        pair.slider_min = 0.0 if key_marks.role(key) is not None else key.slider_min
        pair.slider_max, pair.mute = key.slider_max, key.mute
    pair.relative_key, pair.vertex_group = relative, ""
    shape_keys.write_positions(obj.data, pair, (shape_keys.positions(relative) + moved @ across).astype(np.float32))
    return pair, len(lost)


def _images(obj, pose):
    """{bone: (that across, by its name or else by its place; its turn there)} of {bone: Quaternion}."""
    rig, found = rig_space.armature(obj), {}
    to_rig = rig.matrix_world.inverted_safe() @ obj.matrix_world if pose else Matrix()
    across, bones = to_rig @ _across(obj).to_4x4() @ to_rig.inverted_safe(), rig.data.bones if pose else {}
    ends = np.array([(*bone.head_local, *bone.tail_local) for bone in bones])
    for bone in (bones[name] for name in pose if name in bones):
        image = bpy.utils.flip_name(bone.name)
        away = np.abs(ends - (*(across @ bone.head_local), *(across @ bone.tail_local))).max(axis=1)
        if image == bone.name and away.min() <= SAME_PLACE * np.ptp(ends):
            image = bones[int(away.argmin())].name
        if image in bones:
            frame = (bones[image].matrix_local.inverted() @ across @ bone.matrix_local).to_3x3()
            found[bone.name] = image, (frame @ pose[bone.name].to_matrix() @ frame.inverted()).to_quaternion()
    return found
