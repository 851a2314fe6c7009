# SPDX-License-Identifier: GPL-3.0-or-later
"""Has kept poses driven by the poses of the rig that they are for: on there, off at the others and at rest.

Gradient bands, smooth (Johansen, Automated Semi-Procedural Animation for Character Locomotion, 2009): u of a pose is
the product over the others of smoothstep(-D, D, d - d'), with d and d' the squared distances of the rig from the other
and from the pose, and D between both. A key is u over the sum of all. A pose is where the Y axis of each bone looks,
and the twist around it. Between bones and keys are properties of the mesh object, so that a linked rig serves.
"""

import itertools
import re

import bpy
import numpy as np
from mathutils import Quaternion, Vector

from ... import ids, wording
from ...errors import SceneError
from ...scene import actions, along, key_marks, pose_key, rig_space, shape_keys, subject, vertex_groups
from ...scene.core.key_shapes import KeyShapes
from ...scene.key_marks import Role
from ...widgets.base import MeshOperator

#: On the datablock of the keys: {mark of a key: {bone: its turn}}.
POSES = "meanvalue_poses"

#: The sine of 0.3 degrees: a bone that is turned by less than twice that is not posed. Squared distances: below the
#: first two poses are one, and below the second, of 10 degrees, keys show at each other's pose.
LEAST_TURN, SAME, NEAR = 0.005, 1e-5, 0.03

#: Poses of a group, and factors in an expression, of which Blender keeps 255 characters.
MOST_POSES, FACTORS = 12, 5

_OURS = re.compile(r"u\d+/\(u0(\+u\d+)*\)|clamp\(turn / [-+.e\d]+\)")  # the latter in files of before there were bands


def _turns(obj, key):
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


def _store(key, turns):
    """Gives the key its pose, and a mark by which that is found; an artist's key does not pass for one just kept."""
    taken = [each.slider_min for each in key.id_data.key_blocks if each != key]
    if key_marks.role(key) is None or (key_marks.role(key) == Role.KEPT and key.slider_min in taken):
        counts = itertools.count(int(key_marks.role(key) is None))
        marks = (key_marks.mark(Role.KEPT, key.name + " " * count) for count in counts)
        key.slider_min = next(mark for mark in marks if mark not in taken)
    if POSES not in key.id_data:
        key.id_data[POSES] = {}
    key.id_data[POSES][repr(key.slider_min)] = {name: list(turn) for name, turn in turns.items()}


def _pose(key, rig=None):
    """{bone: Quaternion} that the key is for; empty if that is not known, or of bones that `rig` has no more."""
    pose = key.id_data.get(POSES, {}).get(repr(key.slider_min), {})
    is_there = rig is None or all(name in rig.pose.bones for name in pose.keys())  # noqa: SIM118
    return {name: Quaternion(turn) for name, turn in pose.items()} if is_there else {}


def is_driven(key):
    """Whether its driver is one of ours."""
    curve = actions.driver_of(key)
    return bool(curve and _OURS.fullmatch(curve.driver.expression))


def _is_free(key):
    """Whether neither a driver nor keyframes of an artist's move it."""
    keyframes, _values = actions.read_keys(key.id_data, key.path_from_id("value"))
    return is_driven(key) or not (actions.driver_of(key) or len(keyframes))


def _group(key):
    """The key and those whose poses share bones with its, or with one of these, but for those an artist moves."""
    free = {each: set(_pose(each)) for each in key.id_data.key_blocks if _is_free(each)}
    found, bones = [key], set(_pose(key))
    while more := [each for each in free if each not in found and bones & free[each]]:
        found += more
        bones.update(*(free[each] for each in more))
    return [each for each in key.id_data.key_blocks if each in found]


def _places(poses):
    """(bones, (p, b, 5) where each pose has them, (p, p) squared distances)."""
    bones = sorted(set().union(*poses))
    turns = [[pose.get(bone, Quaternion()) for bone in bones] for pose in poses]
    looks = [[turn @ Vector((0.0, 1.0, 0.0)) for turn in row] for row in turns]
    twists = np.array([[turn.to_swing_twist('Y')[1] for turn in row] for row in turns])
    places = np.dstack([looks, 0.5 * np.cos(twists), 0.5 * np.sin(twists)])
    return bones, places, np.square(places[:, None] - places).sum(axis=(2, 3))


def keep(obj, key):
    """A pose was kept as `key`: for the pose of the rig. What keys for others of its bones show is part of it, since
    they are off there from here on. Returns (these, notes)."""
    turns, mates, notes = _turns(obj, key), [], []
    if turns or POSES in key.id_data:  # none, too: a key of that name may have had one
        _store(key, turns)
    if turns:
        mates = [each for each in _group(key) if each != key and each.value and not each.mute]
        mates = [each for each in mates if _places([turns, _pose(each)])[2][0, 1] > SAME]
    for other in along.group(obj) if mates else ():
        found = {}
        for each in other.data.shape_keys.key_blocks if other.data.shape_keys else ():  # along, those that ours drive
            found[(each.id_data, each.path_from_id("value")) if other == obj else actions.source_of(each)] = each
        kept, *shown = (found.get((each.id_data, each.path_from_id("value"))) for each in (key, *mates))
        if kept is not None:
            shown = [each for each in shown if each is not None]
            shapes = KeyShapes(**vertex_groups.key_parts(other, [vertex_groups.slider_of(other, key) for key in shown]))
            shape = shape_keys.positions(kept) + (shapes.mixed([each.value for each in shown]) - shapes.rest)
            shape_keys.write_positions(other.data, kept, shape.astype(np.float32))
    if mates:
        what = f"What {wording.quoted([each.name for each in mates])} showed is part of '{key.name}'"
        notes.append(f"{what}, since they are for other poses of these bones")
    if any(map(is_driven, mates)):
        try:
            notes += _drive(obj, [key])
        except SceneError as error:
            notes.append(f"Press Drive by Pose. {error}")
    return mates, notes


def _drive(obj, more, without=()):
    """Makes all our drivers anew, with those of the keys `more` and their groups. Returns notes. @throws SceneError."""
    rig, groups, notes = rig_space.armature(obj), [], []
    ours = [key for key in obj.data.shape_keys.key_blocks if is_driven(key) and _pose(key, rig)]
    for key in (*more, *ours):
        if key not in without and not any(key in group for group in groups):
            groups.append([each for each in _group(key) if _pose(each, rig)])
    plans = [(group, *_places([{}, *map(_pose, group)])) for group in groups]
    for group, *_, apart in plans:
        if len(group) > MOST_POSES:
            raise SceneError(f"{len(group)} kept poses share bones, and {MOST_POSES} at most can. Delete some")
        near = np.argwhere((np.triu(apart, 1) >= SAME) & (apart < NEAR))
        pairs = [wording.quoted([["rest", *(key.name for key in group)][each] for each in pair]) for pair in near]
        notes += [f"{pair} are within 10 degrees, so that one shows at the other's pose" for pair in pairs]
    for key in (*more, *ours, *without):
        key.driver_remove("value")
    rest = [key for key in obj.data.shape_keys.key_blocks if is_driven(key)]  # for bones that are gone
    used = {actions.source_of(key)[1][2:].split(":")[0] for key in rest}
    for owner in (obj, *pose_key.sharing(obj)):
        ours = [name for name in owner.keys() if re.match(ids.DRIVE_BY_POSE + r" \d+: (distance|pose) ", name)]  # noqa: SIM118
        for name in [name for name in ours if name.split(":")[0] not in used]:
            owner.driver_remove(f'["{name}"]')
            del owner[name]
    names = (name for name in (f"{ids.DRIVE_BY_POSE} {number}" for number in itertools.count(1)) if name not in used)
    for name, plan in zip(names, plans):  # noqa: B905
        _drive_group(obj, rig, name, *plan)
    return notes


def _drive_group(obj, rig, name, keys, bones, places, apart):
    def chain(what, parts, glue):
        """(obj, path) of the property with the sum or the product of parts, (expression, its sources) each."""
        last = {}
        for number, (expression, sources) in enumerate(parts):
            helper = f"{name}: {what}" + f", {number + 1}" * (number > 0)
            obj[helper], path = 0.0, f'["{helper}"]'
            actions.drive(obj, {**sources, **last}, f"p{glue}{expression}" if last else expression, path)
            last = {"p": (obj, path)}
        return last["p"]

    turns = [{each: (rig, bone, f"ROT_{each.upper()}", 'QUATERNION') for each in "wxyz"} for bone in bones]
    turns = [turn | {"t": (rig, bone, "ROT_Y", 'SWING_TWIST_Y')} for turn, bone in zip(turns, bones, strict=True)]
    first = (apart < SAME).argmax(axis=1)  # keys of one pose share its band
    poses, bands = np.unique(first), {}
    parts = {pose: [*zip(map(_distance, places[pose]), turns, strict=True)] for pose in poses}
    distances = {f"d{pose}": chain(f"distance {pose}", parts[pose], "+") for pose in poses}
    for pose in poses:
        steps = [f"smoothstep({-apart[pose, k]:.7g},{apart[pose, k]:.7g},d{k}-d{pose})" for k in poses if k != pose]
        parts = [("*".join(steps[k : k + FACTORS]), distances) for k in range(0, len(steps), FACTORS)]
        bands[f"u{pose}"] = chain(f"pose {pose}", parts, "*")
    for key, pose in zip(keys, first[1:], strict=True):
        key.slider_max = max(key.slider_max, 1.0)
        actions.drive(key, bands, f"u{pose}/({'+'.join(bands)})")


def _distance(place):
    """In the language of drivers, of the squared distance from a bone's place what is not the same for all places."""
    a, b, c = -2.0 * place[:3]
    twist = np.arctan2(place[4], place[3])
    return f"2*({a:.7g}*(x*y-w*z){b:+.7g}*(.5-x*x-z*z){c:+.7g}*(y*z+w*x))-.5*cos(t{-twist:+.7g})"


def _key(obj):
    """The active shape key, if it is none that posing writes or reads: the pose that was kept last; or None."""
    key = obj.active_shape_key
    is_own = key is not None and key not in {shape_keys.result(obj), obj.data.shape_keys.reference_key}
    return key if is_own else None


def _problem(obj):
    """Why the kept pose takes no driver, in words, or None."""
    key = _key(obj)
    if key is None:
        return "There is no kept pose to drive. Press Keep Pose, or choose a shape key"
    if rig_space.armature(obj) is None:
        return f"'{obj.name}' follows no armature, whose bones could drive the pose"
    curve = actions.driver_of(key)
    if not curve or is_driven(key):
        return None
    return f"Shape key '{key.name}' is driven already. To replace that, delete its driver first"


class MEANVALUE_OT_drive_by_bone(MeshOperator, bpy.types.Operator):
    """Have bones drive the kept pose, and all others of these bones: fully on where it was kept, off at rest"""

    bl_label = ids.DRIVE_BY_POSE
    problems = (_problem,)
    switch = "remove"

    now: bpy.props.BoolProperty(name="As Posed Now", description="At the pose that the rig has now, not the one kept")
    bone: bpy.props.StringProperty(
        name="Bone", description="If empty: those that were posed when it was kept, or are now"
    )
    axis: bpy.props.EnumProperty(
        name="Axis",
        description="The bone's own axis that it turns around",
        items=[(axis, axis, f"Around the bone's {axis}") for axis in "XYZ"],
    )
    angle: bpy.props.FloatProperty(
        name="Angle",
        description="Where the pose is fully on. If it was never given: as the bone is turned now",
        subtype='ANGLE',
    )
    remove: bpy.props.BoolProperty(
        name="Remove", description="Take its driver away, and those of other poses of its bones"
    )

    def invoke(self, context, _event):
        return self.execute(context) if self.remove else context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        layout.use_property_split = True
        layout.prop(self, "now")
        layout.prop_search(self, "bone", rig_space.armature(obj).pose, "bones")
        if self.bone:
            layout.prop(self, "axis")
            layout.prop(self, "angle")
        for key in _group(_key(obj)):
            layout.label(text=f"{key.name}: {wording.listed(_pose(key) or _turns(obj, key))}, now {key.value:.2f}")

    def run(self, obj):
        rig, key = rig_space.armature(obj), _key(obj)
        if self.remove:
            gone = [each for each in _group(key) if is_driven(each)]
            _drive(obj, [], gone)
            return f"{wording.counted(len(gone), 'pose is', 'poses are')} driven no more", []
        turned, has_angle = _turns(obj, key), self.properties.is_property_set("angle")
        pose = (not self.now and _pose(key, rig)) or turned
        if self.bone and self.bone not in rig.pose.bones:
            raise SceneError(f"'{rig.name}' has no bone '{self.bone}'. Choose one that it has")
        if self.bone or has_angle:
            bone = self.bone or max(turned, key=lambda name: Vector(turned[name][1:]).length, default="")
            if has_angle and bone:
                turned[bone] = Quaternion([float(axis == self.axis) for axis in "XYZ"], self.angle)
            pose = {bone: turned[bone]} if bone in turned else {}
        if not any(Vector(turn[1:]).length >= LEAST_TURN for turn in pose.values()):
            raise SceneError("No bone is turned. Pose the bone that is to drive it, or give bone and angle")
        lost = [f"Range Min was {key.slider_min:g}, and is 0"] * (key.slider_min < -0.01)
        _store(key, pose)
        notes = _drive(obj, [key]) + lost
        names = wording.quoted([each.name for each in _group(key)], limit=MOST_POSES)
        return f"The pose of {wording.quoted(pose)} drives {names}", notes
