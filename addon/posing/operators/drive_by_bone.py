# SPDX-License-Identifier: GPL-3.0-or-later
"""Has a bone drive a kept pose: off where the bone rests, fully on where it is now."""

import bpy

from ... import ids, wording
from ...errors import SceneError
from ...scene import actions, rig_space, shape_keys, subject
from ...widgets.base import MeshOperator

AXES = "XYZ"

#: A bone that is turned by less, in radians, is not posed.
LEAST_ANGLE = 0.01


def _kept(obj):
    """The active shape key, if it is none that posing writes or reads: the pose that was kept last; or None."""
    key = obj.active_shape_key
    is_own = key is not None and key not in {shape_keys.result(obj), obj.data.shape_keys.reference_key}
    return key if is_own else None


def _problem(obj):
    """Why the kept pose takes no driver, in words, or None."""
    key = _kept(obj)
    if key is None:
        return "There is no kept pose to drive. Press Keep Pose, or choose a shape key"
    if rig_space.armature(obj) is None:
        return f"'{obj.name}' follows no armature, whose bones could drive the pose"
    curve = actions.driver_of(key)
    if not curve:
        return None
    used = [target for variable in curve.driver.variables for target in variable.targets if target.id is not None]
    by = wording.quoted(list(dict.fromkeys(target.bone_target or target.id.name for target in used)))
    return f"Shape key '{key.name}' is driven already{by and f' by {by}'}. To replace that, delete its driver first"


class MEANVALUE_OT_drive_by_bone(MeshOperator, bpy.types.Operator):
    """Have a bone drive the kept pose: off where the bone rests, fully on at the angle that it has now"""

    bl_label = "Drive by Bone"
    problems = (_problem,)

    bone: bpy.props.StringProperty(
        name="Bone",
        description="If empty: the bone that is turned most",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    axis: bpy.props.EnumProperty(
        name="Axis",
        description="The bone's own axis that it turns around",
        items=[(axis, axis, f"Around the bone's {axis}") for axis in AXES],
        options={'SKIP_SAVE'},
    )
    angle: bpy.props.FloatProperty(
        name="Angle",
        description="Where the pose is fully on. If it was never given: the angle that the bone has now",
        subtype='ANGLE',
        options={'SKIP_SAVE'},
    )

    def invoke(self, context, _event):
        obj = subject.of(context)
        self._fill_in(rig_space.armature(obj))
        return context.window_manager.invoke_props_dialog(self)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop_search(self, "bone", rig_space.armature(subject.of(context)).pose, "bones")
        layout.prop(self, "axis")
        layout.prop(self, "angle")

    def run(self, obj):
        rig, key = rig_space.armature(obj), _kept(obj)
        self._fill_in(rig)
        if self.bone and self.bone not in rig.pose.bones:
            raise SceneError(f"'{rig.name}' has no bone '{self.bone}'. Choose one that it has")
        if not self.bone or abs(self.angle) < LEAST_ANGLE:
            raise SceneError("No bone is turned. Pose the bone that is to drive it, or give bone and angle")
        driver = key.driver_add("value").driver
        variable = driver.variables.new()
        variable.name, variable.type = "turn", 'TRANSFORMS'
        target = variable.targets[0]
        target.id, target.bone_target = rig, self.bone
        target.transform_type, target.transform_space = f"ROT_{self.axis}", 'LOCAL_SPACE'
        target.rotation_mode = f"SWING_TWIST_{self.axis}"
        driver.type, driver.expression = 'SCRIPTED', f"clamp(turn / {self.angle:.9g})"
        at = f"{self.angle * 57.29578:.0f} degrees around {self.axis}"
        return f"Bone '{self.bone}' drives '{key.name}': fully on at {at}", []

    def _fill_in(self, rig):
        """What was not given."""
        given = self.properties.is_property_set
        if not given("bone"):
            turned = [(max(map(abs, _angles(rig, bone))), bone.name) for bone in rig.pose.bones]
            self.bone = max((each for each in turned if each[0] >= LEAST_ANGLE), default=(0.0, ""))[1]
        bone = rig.pose.bones.get(self.bone)
        if bone is None:
            return
        angles = _angles(rig, bone)
        if not given("axis"):
            self.axis = AXES[max(range(3), key=lambda axis: abs(angles[axis]))]
        if not given("angle"):
            self.angle = angles[AXES.index(self.axis)]


def _angles(rig, bone):
    """How far a pose bone is turned around each of its own axes, as the driver's variable has it."""
    local = rig.convert_space(pose_bone=bone, matrix=bone.matrix, from_space='POSE', to_space='LOCAL')
    return [local.to_quaternion().to_swing_twist(axis)[1] for axis in AXES]
