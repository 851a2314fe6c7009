# SPDX-License-Identifier: GPL-3.0-or-later
"""Arms and legs of a rigged figure: how they are posed, and where handles hold them."""

import bpy
import numpy as np
from mathutils import Matrix, Vector

from ..rig.run import turn

#: Degrees by which arms are lowered and swung forward, elbows bent, thighs lifted, knees bent on the left; the right
#: has those of the row three further down. The rig's own animation, and poses that are not in it.
ANIMATED = (
    (-50, 0, 20, 0, 0), (40, 30, 90, 40, 60), (60, -30, 30, 80, 100), (0, 50, 130, 20, 90), (-30, 0, 110, 60, 20),
    (70, 40, 0, 0, 120), (20, -40, 60, 90, 40), (50, 60, 120, 30, 30), (-60, 20, 60, 50, 110), (10, -20, 20, 70, 70),
)  # fmt: skip
ASKED = ((30, 20, 75, 50, 80), (-20, 0, 100, 70, 50), (55, -10, 50, 15, 100))
STRAIGHT = 0.05  # sine of the angle of an elbow
EVERY = 10  # frames from one pose to the next

#: Over the length of the upper limb: how big handles are at hands, feet and joints, and what counts as around a joint.
END, SOLE, TIP, AROUND = 0.35, 0.3, 0.12, 0.5


#: Bones at whose heads the body is held where it is.
TRUNK = ("pelvis", "chest", "head")


def bend(armature, poses, number):
    """Poses arms and legs: pose `number` of `poses` on the left, another on the right."""
    for posed in armature.pose.bones:
        posed.matrix_basis = Matrix.Identity(4)
    bpy.context.view_layer.update()
    for side, sign in (("L", 1.0), ("R", -1.0)):
        shift = 0 if side == "L" else 3
        lowered, swung, elbow, lifted, knee = poses[(number + shift) % len(poses)]
        swing = Matrix.Rotation(np.radians(-swung), 3, 'X') @ Matrix.Rotation(np.radians(sign * lowered), 3, 'Y')
        upper_arm, forearm = (armature.data.bones[f"{bone}.{side}"] for bone in ("upper_arm", "forearm"))
        end = armature.data.bones[f"forearm.{side}"].tail_local
        hinge = elbow_hinge(forearm.head_local - upper_arm.head_local, end - forearm.head_local)
        turn(armature, upper_arm.name, (0.0, 1.0, 0.0), sign * lowered)
        turn(armature, upper_arm.name, (1.0, 0.0, 0.0), -swung)
        turn(armature, forearm.name, tuple(swing @ Vector(hinge)), elbow)
        turn(armature, f"thigh.{side}", (1.0, 0.0, 0.0), -lifted)
        turn(armature, f"shank.{side}", (1.0, 0.0, 0.0), knee)


def elbow_hinge(upper_arm, forearm):
    """(3,): the axis about which an elbow bends, forward where it is straight; (3,) along both bones."""
    upper_arm, forearm = (np.array(along) / np.linalg.norm(along) for along in (upper_arm, forearm))
    axis = np.cross(upper_arm, forearm)
    if np.linalg.norm(axis) < STRAIGHT:
        axis = np.cross(upper_arm, (0.0, -1.0, 0.0))
    return axis / np.linalg.norm(axis)


def animate(armature):
    """Keys the poses of ANIMATED."""
    bones = [f"{bone}.{side}" for bone in ("upper_arm", "forearm", "thigh", "shank") for side in "LR"]
    for number in range(len(ANIMATED)):
        bend(armature, ANIMATED, number)
        for bone in bones:
            armature.pose.bones[bone].keyframe_insert("rotation_quaternion", frame=1 + EVERY * number)
    bpy.context.scene.frame_end = 1 + EVERY * (len(ANIMATED) - 1)


def rest(armature):
    """Takes the animation off the rig."""
    armature.animation_data_clear()
    for posed in armature.pose.bones:
        posed.matrix_basis = Matrix.Identity(4)
    bpy.context.view_layer.update()


def holds(figure):
    """{name: vertices} of handles at hands and feet, elbows and knees, and of pins on the trunk."""
    found = {}
    for side in "LR":
        arm, leg = (_length(figure, f"{bone}.{side}", f"{next_bone}.{side}")
                    for bone, next_bone in (("upper_arm", "forearm"), ("thigh", "shank")))  # fmt: skip
        found[f"Hand.{side}"] = near(figure, figure.bones[f"forearm.{side}"][1], END * arm)
        found[f"Foot.{side}"] = near(figure, figure.bones[f"shank.{side}"][1], SOLE * leg)
        for name, bone, length, out in (("Elbow", "forearm", arm, 1.0), ("Knee", "shank", leg, -1.0)):
            tip = np.array(figure.bones[f"{bone}.{side}"][0])
            tip[1] += 0.2 * out * length
            nearest = figure.vertices[np.linalg.norm(figure.vertices - tip, axis=1).argmin()]
            found[f"{name}.{side}"] = near(figure, nearest, TIP * length)
    for bone in TRUNK:
        found[f"Trunk {bone}"] = near(figure, figure.bones[bone][0], END * arm)
    return found


def joints(figure):
    """{name: vertices around the joints of both sides}."""
    bones = {
        "elbows": ("forearm", "upper_arm"),
        "shoulders": ("upper_arm", "forearm"),
        "knees": ("shank", "thigh"),
        "hips": ("thigh", "shank"),
    }
    found = {}
    for name, (bone, other) in bones.items():
        reach = AROUND * _length(figure, f"{bone}.L", f"{other}.L")
        sides = [near(figure, figure.bones[f"{bone}.{side}"][0], reach) for side in "LR"]
        found[name] = np.unique(np.concatenate(sides))
    return found


def near(figure, place, distance):
    return np.flatnonzero(np.linalg.norm(figure.vertices - np.array(place), axis=1) < distance)


def _length(figure, bone, next_bone):
    return float(np.linalg.norm(np.array(figure.bones[bone][0]) - np.array(figure.bones[next_bone][0])))
