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
from ...errors import SceneError, require_none
from ...scene import actions, key_marks, rig_space, shape_keys, subject
from ...widgets.base import MeshOperator
from ..bridge import key_poses
from ..bridge.key_poses import LEAST_TURN, follow_bones, is_driven, is_free, pose_of, store, turns_now

#: Squared distances: below the first two poses are one, and below the second, of 10 degrees, keys show at each other's.
SAME, NEAR = 1e-5, 0.03

#: Poses of a group, and factors in an expression, of which Blender keeps 255 characters.
MOST_POSES, FACTORS = 12, 5


def group_of(key):
    """The key and those whose poses share bones with its, or with one of these, but for those an artist moves."""
    free = {each: set(pose_of(each)) for each in key.id_data.key_blocks if is_free(each)}
    found, bones = [key], set(pose_of(key))
    while more := [each for each in free if each not in found and bones & free[each]]:
        found += more
        bones.update(*(free[each] for each in more))
    return [each for each in key.id_data.key_blocks if each in found]


def places_of(poses):
    """(bones, (p, b, 5) where each pose has them, (p, p) squared distances)."""
    bones = sorted(set().union(*poses))
    turns = [[pose.get(bone, Quaternion()) for bone in bones] for pose in poses]
    looks = [[turn @ Vector((0.0, 1.0, 0.0)) for turn in row] for row in turns]
    twists = np.array([[turn.to_swing_twist('Y')[1] for turn in row] for row in turns])
    places = np.dstack([looks, 0.5 * np.cos(twists), 0.5 * np.sin(twists)])
    return bones, places, np.square(places[:, None] - places).sum(axis=(2, 3))


def drive(obj, more, without=()):
    """Makes all our drivers anew, with those of the keys `more` and their groups. Returns notes. @throws SceneError."""
    rig, groups, notes = rig_space.armature(obj), [], []
    ours = [key for key in obj.data.shape_keys.key_blocks if is_driven(key) and pose_of(key, rig)]
    for key in (*more, *ours):
        if key not in without and not any(key in group for group in groups):
            groups.append([each for each in group_of(key) if pose_of(each, rig)])
    plans = [(group, *places_of([{}, *map(pose_of, group)])) for group in groups]
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
    for owner in (obj, *key_marks.sharing(obj)):
        ours = [name for name in owner.keys() if re.match(ids.DRIVE_BY_POSE + r" \d+: (distance|pose) ", name)]  # noqa: SIM118
        for name in [name for name in ours if name.split(":")[0] not in used]:
            owner.driver_remove(f'["{name}"]')
            del owner[name]
    names = (name for name in (f"{ids.DRIVE_BY_POSE} {number}" for number in itertools.count(1)) if name not in used)
    for name, plan in zip(names, plans):  # noqa: B905
        __drive_group(obj, rig, name, *plan)
    return notes


def __drive_group(obj, rig, name, keys, bones, places, apart):
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
    is_there = _key(obj) or key_marks.of_role(obj.data.shape_keys, key_marks.Role.KEPT)
    return None if is_there else "There is no kept pose. Press Keep Pose, or choose a shape key"


def _driver_problem(obj, key):
    """Why the kept pose takes no driver, in words, or None."""
    if rig_space.armature(obj) is None:
        return f"'{obj.name}' follows no armature, whose bones could drive the pose"
    if not actions.driver_of(key) or is_driven(key):
        return None
    return f"Shape key '{key.name}' is driven already. To replace that, delete its driver first"


def _side(name):
    """L and left come before R and right: -1; they come after: 1; neither: 0."""
    flipped = bpy.utils.flip_name(name)
    return (name > flipped) - (name < flipped)


def _refresh(obj, keys, writes):
    """As run() returns."""
    found, edited = key_poses.refresh(obj, keys, writes) if rig_space.armature(obj) else ({}, [])
    if not found:
        raise SceneError("What kept poses showed is not known. Pose the rig, and Drive by Pose > As Posed Now")
    off = {name: pair for name, pair in found.items() if pair[0] > key_poses.OFF}
    lines = [f"'{name}': {before:.2%} of the size off, now {then:.2%}" for name, (before, then) in off.items()]
    left = writes and any(then > key_poses.OFF for name, (_, then) in off.items() if name not in edited)
    notes = ["What modifiers smooth away, as Corrective Smooth does, no key brings back"] if left else []
    told = f"Edited since, and left as they are: {wording.quoted(edited)}. To keep that, tick As Posed Now"
    notes += [told] if edited else []
    return [f"{len(off)} of {wording.counted(len(found), 'kept pose')} off", *lines], notes


def _mirror(obj, key, all_of_side):
    """As run() returns."""
    if not _side(key.name):
        raise SceneError(f"The name of '{key.name}' tells no side. Let it end in .L or .R")
    ours = shape_keys.made_names(obj)
    sided = [each for each in key.id_data.key_blocks if each.name not in ours and _side(each.name) == _side(key.name)]
    former = {each.name: (each.slider_min, each.vertex_group) for each in key.id_data.key_blocks}
    pairs, alone, lost, own = key_poses.mirror(obj, sided if all_of_side else [key])
    notes = [f"No bone is across from {wording.quoted(alone)}"] if alone else []
    notes += [f"{wording.vertices(lost)} without a mirror image go as the surface there does"] if lost else []
    own += [each.name for pair in pairs.items() for each in pair if not is_free(each)]
    notes += [f"Keys, drivers and keyframes of your own are not mirrored: {wording.quoted(own)}"] if own else []
    for pair in pairs.values():
        low, group = former.get(pair.name, (0.0, ""))
        notes += [f"Range Min of '{pair.name}' was {low:g}, and is 0"] * (abs(low - pair.slider_min) > 0.01)
        notes += [f"What '{group}' masked is part of '{pair.name}'"] * bool(group)
    driven = [pair for each, pair in pairs.items() if is_driven(each) and is_free(pair)]
    try:
        notes += drive(obj, driven) if driven else []
    except SceneError as error:
        notes.append(f"Press Drive by Pose. {error}")
    names = wording.quoted([pair.name for pair in pairs.values()])
    return f"{names} mirror the other side", [*notes, *subject.sharing_notes(obj)]


class MEANVALUE_OT_drive_by_bone(MeshOperator, bpy.types.Operator):
    """Have bones drive the kept pose, and all others of these bones: fully on where it was kept, off at rest"""

    bl_label = ids.DRIVE_BY_POSE
    problems = (_problem,)
    switch = "remove"

    does: bpy.props.EnumProperty(
        name="Does",
        description="What becomes of the kept pose",
        items=(
            ('DRIVE', "Drive", "Have bones drive it, and all others of these bones: on where it was kept, off at rest"),
            ('POSE', "Pose the Rig", "Turn the bones to the pose that it is for"),
            ('REFRESH', "Refresh", "Have it show what it showed at its pose, after weights or modifiers changed"),
            ('REFRESH_ALL', "Refresh All", "Have all kept poses show what they showed at theirs"),
            ('CHECK', "Check All", "Tell which kept poses do not show what they showed, and by how much"),
            ('MIRROR', "Mirror or Update the Pair", "Make the key of the other side like this one, as .L and .R tell"),
            ('MIRROR_ALL', "Mirror All", "Make those of the other side like all of this side"),
        ),
    )
    key: bpy.props.StringProperty(name="Key", description="If empty: the active shape key", options={'HIDDEN'})
    now: bpy.props.BoolProperty(name="As Posed Now", description="At the pose that the rig has now, not the one kept")
    bone: bpy.props.StringProperty(name="Bone", description="If empty: those posed when it was kept, or posed now")
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
    remove: bpy.props.BoolProperty(name="Remove", description="Take away its driver, and those of poses of its bones")

    @classmethod
    def description(cls, context, properties):
        item = properties.bl_rna.properties["does"].enum_items[properties.does]
        return super().description(context, properties) or item.description

    def invoke(self, context, _event):
        obj = subject.of(context)
        if self.remove or self.does != 'DRIVE' or not _key(obj) or _driver_problem(obj, _key(obj)):
            return self.execute(context)
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        if self.does != 'DRIVE' or self.remove:
            return
        layout.use_property_split = True
        layout.prop(self, "now")
        layout.prop_search(self, "bone", rig_space.armature(obj).pose, "bones")
        if self.bone:
            layout.prop(self, "axis")
            layout.prop(self, "angle")
        for key in group_of(_key(obj)):
            layout.label(text=f"{key.name}: {wording.listed(pose_of(key) or turns_now(obj, key))}, now {key.value:.2f}")

    def run(self, obj):
        rig, key = rig_space.armature(obj), obj.data.shape_keys.key_blocks.get(self.key) or _key(obj)
        require_none(None if key else "No kept pose is chosen. Choose its shape key")
        follow_bones(obj)
        if self.remove:
            gone = [each for each in group_of(key) if is_driven(each)]
            drive(obj, [], gone)
            return f"{wording.counted(len(gone), 'pose is', 'poses are')} driven no more", []
        if self.does == 'POSE':
            return key_poses.pose_rig(rig, group_of(key), key), []
        if self.does in ('REFRESH', 'REFRESH_ALL', 'CHECK'):
            return _refresh(obj, [key] if self.does == 'REFRESH' else key.id_data.key_blocks[:], self.does != 'CHECK')
        if self.does != 'DRIVE':
            return _mirror(obj, key, self.does == 'MIRROR_ALL')
        require_none(_driver_problem(obj, key))
        turned, has_angle = turns_now(obj, key), self.properties.is_property_set("angle")
        stored = pose_of(key, rig)
        pose = (not self.now and stored) or turned
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
        if pose is not stored:
            store(obj, key, pose)
        if pose is turned:
            key_poses.note_shown(obj, key)
        notes = drive(obj, [key]) + lost
        names = wording.quoted([each.name for each in group_of(key)], limit=MOST_POSES)
        return f"The pose of {wording.quoted(pose)} drives {names}", notes
