# SPDX-License-Identifier: GPL-3.0-or-later
"""What uses the pose that is shown: Keep Pose, Apply as Rest, and Finish, which takes away what the add-on made for
it; and Sample Rig Poses, of which others are made."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...live import engine
from ...scene import actions, along, declarations, key_marks, new_rest, shape_keys, subject, vertex_groups
from ...scene.core import point_sets
from ...scene.key_marks import Role
from ...scene.pose_object_making import remove_bare
from ...scene.pose_objects import shown
from ...solver import session
from ...widgets.background import BackgroundOperator
from ..bridge import control_places, controls, examples, key_poses, new_handles, region, scene_input, targets
from ..bridge.scene_input import CONTROLS, Posing
from . import drive_by_bone


class SettledOperator(BackgroundOperator):
    """Mix-in of those that use the pose that is shown. Subclasses define use(obj) in place of run(obj): it finds the
    settled answer in the result key, which may lag behind the controls while it is live."""

    doing = "Settling"

    def prepare(self, obj):
        return None if _is_settled(obj) else Posing(obj, CONTROLS, is_checked=False, settles=True)

    def finish(self, obj, prepared, outcome):
        if prepared is not None:
            session.remember(prepared.bind_input, prepared.binding)
            along.write_result(obj, outcome[0])
        elif not _is_settled(obj):
            raise SceneError(f"A handle of '{obj.name}' was moved meanwhile. Try again")
        return self.use(obj)


def _unposed_problem(obj):
    """Why there is no pose to use, in words, or None."""
    if shape_keys.result(obj) is None:
        return "Nothing is posed yet. Press on the mesh with Grab and drag"
    return shape_keys.why_result_is_hidden(obj)


def _is_settled(obj):
    """A mix of shape keys has no say in the pose."""
    return not obj.meanvalue.live or engine.is_settled(obj)


def _keep_for_rig(obj, key):
    """A pose was kept as `key`: for the pose of the rig. What keys for others of its bones show is part of it, since
    they are off there from here on. Returns (these, notes)."""
    turns, mates, notes = key_poses.turns_now(obj, key), [], []
    if turns or key_poses.POSES in key.id_data:  # none, too: a key of that name may have had one
        key_poses.store(obj, key, turns)
    if turns:
        mates = [each for each in drive_by_bone.group_of(key) if each != key and each.value and not each.mute]
        apart = (drive_by_bone.places_of([turns, key_poses.pose_of(each)])[2][0, 1] for each in mates)
        mates = [each for each, away in zip(mates, apart, strict=True) if away > drive_by_bone.SAME]
    for other, kept in along.keys_of(obj, key) if mates else ():
        shown = [own for each in mates for who, own in along.keys_of(obj, each) if who == other]
        shapes = vertex_groups.shapes_of(other, [vertex_groups.slider_of(other, each) for each in shown])
        shape = shape_keys.positions(kept) + (shapes.mixed([each.value for each in shown]) - shapes.rest)
        shape_keys.write_positions(other.data, kept, shape.astype(np.float32))
    if turns:
        key_poses.note_shown(obj, key)
    if mates:
        what = f"What {wording.quoted([each.name for each in mates])} showed is part of '{key.name}'"
        notes.append(f"{what}, since they are for other poses of these bones")
    if any(map(drive_by_bone.is_driven, mates)):
        try:
            notes += drive_by_bone.drive(obj, [key])
        except SceneError as error:
            notes.append(f"Press Drive by Pose. {error}")
    return mates, notes


class MEANVALUE_OT_keep_pose(SettledOperator, bpy.types.Operator):
    """Hand the pose over to a new shape key, whose slider has it from here on. The handles pose on top of it"""

    bl_label = "Keep Pose"
    problems = (_unposed_problem,)

    name: bpy.props.StringProperty(
        name="Name", description="Name of the new shape key. If empty: that of the part that is posed"
    )

    def use(self, obj):
        shape, rest = shape_keys.pose_to_use(obj), shape_keys.rest_positions(obj.data)
        key = shape_keys.add_shape(obj, self.name.strip() or new_handles.named_pose(obj, shape - rest), shape)
        key.slider_min = key_marks.mark(Role.KEPT, key.name)
        name = key.name
        along.keep(obj, key)
        others, notes = _keep_for_rig(obj, key)
        obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(name)  # the panel shows its slider
        handles = targets.followed_handles(obj)
        if any(actions.is_animated(each.control) or len(controls.mover(each).constraints) for each in handles):
            how = "fades" if key_marks.give_way(obj, key) else "has its own keyframes or driver, and does not fade"
            return f"The pose is kept as shape key '{name}', at value 0. The handles' pose {how} as you raise it", notes
        engine.look_again(obj)
        with engine.held():
            for each in others:
                each.value = 0.0
            key.value = 1.0
            along.write_result(obj, rest)
            control_places.reset(obj, handles)
        obj.update_tag()
        bpy.context.view_layer.update()
        return f"The pose is kept as shape key '{name}'", notes


class MEANVALUE_OT_apply_pose(SettledOperator, bpy.types.Operator):
    """Make the pose the new rest shape, to pose on from there. Other shape keys are carried along"""

    bl_label = "Apply as Rest"
    problems = (_unposed_problem,)

    def use(self, obj):
        handles = [handle for handle in obj.meanvalue.handles if handle.control is not None]
        controls.require_places(obj, handles)  # throws before anything is changed
        engine.look_again(obj)
        notes = new_rest.become(obj)
        declarations.clear(obj.meanvalue.bound)
        controls.attach_where_they_are(obj, handles)
        return "The pose is the rest shape now", [*notes, *subject.sharing_notes(obj)]


#: Of the mesh's size: what is nearer to the rest shape is no pose, since it was settled to no more than that.
SAME_POSE = 1e-4


def _finish_problem(obj):
    """Why there is nothing to finish, or it is not this object's alone, as a sentence, or None."""
    if not obj.meanvalue.handles and not shape_keys.result(obj) and shown(obj) == obj:
        return f"'{obj.name}' has no handles, pins or pose, so there is nothing to finish"
    if obj.meanvalue.baked.target:
        return shape_keys.BAKE_PLAYS
    ours = {handle.control for handle in obj.meanvalue.handles}
    for other in _with_the_pose(obj):
        if any(_is_own(other, handle, ours) for handle in other.meanvalue.handles):
            return f"'{other.name}' poses the same mesh by its own handles. Remove those, or make it a single user"
    return None


def _with_the_pose(obj):
    """The other objects whose pose is that of `obj`, as linked duplicates have it."""
    return [each for each in shape_keys.sharing(obj) if each.meanvalue.result_key == obj.meanvalue.result_key]


def _is_own(obj, handle, taken):
    """Whether a handle has a control that a linked duplicate has not merely taken over. taken: those of the other."""
    is_chosen = not handle.made_control and handle.control not in taken
    return handle.control is not None and (is_chosen or controls.owner_of(handle.control) == obj)


class MEANVALUE_OT_finish(SettledOperator, bpy.types.Operator):
    """Remove handles, pins and what was made for them, and keep the pose, or take it back"""

    bl_label = "Finish"
    problems = (_finish_problem,)

    keep: bpy.props.EnumProperty(
        name="Keep",
        description="What becomes of the pose",
        items=(
            ('SHAPE_KEY', "As Shape Key", "Keep the pose as a shape key, fully on", 'SHAPEKEY_DATA', 0),
            ('REST', "As Rest Shape", "Make the pose the rest shape. Other shape keys go along", 'MESH_DATA', 1),
            ('NOTHING', "Nothing", "Take the pose back", 'X', 2),
        ),
    )

    @classmethod
    def description(cls, _context, properties):
        kept = properties.bl_rna.properties["keep"].enum_items[properties.keep].description
        return f"{kept}. Remove handles, pins and what was made for them"

    def prepare(self, obj):
        return None if self.keep == 'NOTHING' else super().prepare(obj)

    def use(self, obj):
        engine.look_again(obj)
        kept, notes = self._keep(obj)
        for other in _with_the_pose(obj):
            other.meanvalue.live = False
        removed, notes = remove_what_was_made(obj), [*notes, *subject.sharing_notes(obj)]
        remove_bare(obj)
        return f"{kept}. {removed} removed", notes

    def _keep(self, obj):
        """Returns (sentence, [notes])."""
        key, shape, rest = shape_keys.result(obj), shape_keys.result_positions(obj), shape_keys.rest_positions(obj.data)
        near = SAME_POSE * point_sets.bounding_box_diagonal(rest)
        is_posed = shape is not None and np.abs(shape - rest).max() > near
        notes = new_rest.become(obj) if is_posed and self.keep == 'REST' else []
        obj.meanvalue.live = False
        if is_posed and self.keep == 'SHAPE_KEY':
            is_named = key.name != ids.DEFAULT_RESULT_KEY
            name = key.name if is_named else new_handles.named_pose(obj, shape - rest)
            for each in filter(None, map(shape_keys.result, along.group(obj))):
                each.name = name
                each.slider_min = key_marks.mark(Role.KEPT, each.name)
            others, notes = _keep_for_rig(obj, key)
            for each in others:
                each.value = 0.0
            return f"The pose is shape key '{key.name}'", notes
        along.remove_pose(*along.group(obj))
        return "The pose is the rest shape now" if is_posed and self.keep == 'REST' else "The mesh is as it was", notes


def remove_what_was_made(obj):
    """Takes away all handles, what was made for them, the region and the binding. Returns how many, in words."""
    settings = obj.meanvalue
    count = len(settings.handles)
    if bpy.context.object != shown(obj):
        subject.choose(obj)
    for index in reversed(range(count)):
        controls.remove_handle(obj, index)
    region.remove_made_group(obj)
    if settings.bound.is_bound:
        scene_input.release(settings.bound)
    along.release(obj)
    return wording.counted(count, "handle or pin", "handles and pins")


class MEANVALUE_OT_sample_rig_poses(BackgroundOperator, bpy.types.Operator):
    """Keep the poses of the animated rig that differ most as shape keys, in place of those sampled before, and pose \
the mesh like them. They stay muted: the rig would bend an unmuted one twice"""

    bl_label = "Sample Rig Poses"
    doing = "Sampling the rig of"
    problems = (examples.rig_problem,)

    count: bpy.props.IntProperty(
        name="Poses", description="How many poses to keep at most", default=8, min=1, soft_max=16, max=64
    )

    def prepare(self, obj):
        return examples.RigPoses(obj, bpy.context.scene, self.count)

    def before(self, prepared):
        with engine.held():
            for share in prepared.sample(self.object):
                yield "going through the animation", share

    def finish(self, obj, prepared, _outcome):
        names = prepared.write(obj)
        poses = wording.counted(len(names), "pose")
        return f"'{obj.name}' is posed like {poses} of its rig: {wording.quoted(names, limit=8)}", []
