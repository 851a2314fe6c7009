# SPDX-License-Identifier: GPL-3.0-or-later
"""A generated figure that walks: joints by forward kinematics, 41 markers on them, gaps and noise by seed.

Metres, Z up, 100 Hz. In its T-pose it stands on z = 0 at the origin, looks along -Y (as Blender's characters do) and
has its left at +X; it walks along -Y. Labels are those of OptiTrack's Baseline 41 set. Needs numpy alone.

A foot strikes with the heel, lies flat, rolls over its ball while its toes lie flat, and leaves: where `contacts` says
that heel or toes are on the ground, the point that the foot stands on does not move by a hair (markers, which are off
it, tilt a little while the foot rolls). Hips, knees and ankles are solved exactly: bones keep their lengths,
`knee_angles` is the truth.
"""

import itertools
from dataclasses import dataclass

import numpy as np

RATE_HZ = 100.0
CYCLE = 1.1  # seconds from one strike of a heel to its next
STRIDE = 1.2  # metres in that time, for legs of full length
STAIRS_STRIDE = 0.6  # two stairs
HEIGHT = 1.79  # with legs of full length


THIGH, SHANK, ANKLE_HEIGHT = 0.43, 0.42, 0.08
# Where a foot rolls, from the ankle.
HEEL, TOE = np.array([0.0, 0.05, -ANKLE_HEIGHT]), np.array([0.0, -0.11, -ANKLE_HEIGHT])

# Phases of a foot: flat, heel off, toe off, then in the air to the next strike at 1.
FLAT, HEEL_OFF, TOE_OFF = 0.10, 0.40, 0.63
PITCH = ((0.0, 18.0), (FLAT, 0.0), (HEEL_OFF, 0.0), (TOE_OFF, -54.0), (1.0, 18.0))  # degrees, toes up is positive

#: label (without side): (bone, place from the joint that the bone hangs on, in the T-pose, of the left side).
#: On thighs and shanks Z is a share of the bone.
CENTRE_MARKERS = {
    "HeadTop": ("head", (0.0, 0.0, 0.24)),
    "HeadFront": ("head", (0.0, -0.105, 0.17)),
    "HeadSide": ("head", (0.085, 0.01, 0.16)),
    "BackTop": ("chest", (0.0, 0.09, 0.30)),
    "BackLeft": ("chest", (0.09, 0.12, 0.12)),
    "BackRight": ("chest", (-0.07, 0.125, 0.18)),
    "Chest": ("chest", (0.02, -0.125, 0.16)),
    "WaistLFront": ("pelvis", (0.13, -0.11, 0.06)),
    "WaistRFront": ("pelvis", (-0.13, -0.11, 0.06)),
    "WaistLBack": ("pelvis", (0.06, 0.125, 0.08)),
    "WaistRBack": ("pelvis", (-0.06, 0.125, 0.08)),
}
SIDE_MARKERS = {
    "ShoulderTop": ("chest", (0.16, 0.0, 0.355)),
    "ShoulderBack": ("chest", (0.15, 0.085, 0.22)),
    "UArmHigh": ("upper_arm", (0.14, 0.045, 0.03)),
    "ElbowOut": ("upper_arm", (0.27, 0.045, 0.0)),
    "WristOut": ("forearm", (0.245, 0.034, 0.004)),
    "WristIn": ("forearm", (0.245, -0.034, -0.004)),
    "HandOut": ("forearm", (0.33, 0.01, 0.028)),
    "Thigh": ("thigh", (0.085, -0.03, -0.55)),
    "KneeOut": ("thigh", (0.062, 0.0, -1.0)),
    "Shin": ("shank", (0.05, -0.025, -0.5)),
    "AnkleOut": ("shank", (0.045, 0.005, -1.0)),
    "Heel": ("foot", (0.0, 0.067, -0.045)),
    "ToeIn": ("foot", (-0.045, -0.125, -0.045)),
    "ToeOut": ("foot", (0.055, -0.105, -0.05)),
    "ToeTip": ("toe", (0.0, -0.055, 0.03)),
}
LABELS = tuple(CENTRE_MARKERS) + tuple(side + name for side in "LR" for name in SIDE_MARKERS)
FOOT_LABELS = {"L": ("LHeel", "LToeIn", "LToeOut", "LToeTip"), "R": ("RHeel", "RToeIn", "RToeOut", "RToeTip")}


@dataclass(frozen=True, eq=False)
class Figure:
    """What a take is made of. f frames, 41 markers.

    positions (f, 41, 3) with NaN in gaps; clean (f, 41, 3) without gaps and noise; joints: name -> (f, 3);
    contacts: "heel.L", "toe.L", "heel.R", "toe.R" -> (f,) bool; knee_angles: "L", "R" -> (f,) degrees, 0 is straight.
    """

    labels: tuple
    rate_hz: float
    positions: np.ndarray
    clean: np.ndarray
    joints: dict
    contacts: dict
    knee_angles: dict
    height: float


def take(frames=255, seed=0, legs=1.0, gaps=0.0, noise=0.0, longest_gap=20, start=0.0, drop=0.0):
    """The walk as a `Figure`.

    legs: length of thighs and shanks over the normal one, strides become as much shorter. gaps: share of samples that
    are missing, in runs of 1 to `longest_gap` samples. noise: standard deviation in metres. start: first second.
    drop: metres that the stairs go down with each stride.
    """
    time = start + np.arange(frames) / RATE_HZ
    joints, turns, contacts = walking(time, legs, drop)
    return figure(joints, turns, contacts, seed, legs, gaps, noise, longest_gap)


def t_pose(legs=1.0, seed=0, noise=0.0, frames=1):
    """The figure at rest, arms to the sides, as a `Figure` of `frames` frames."""
    joints, turns = upright(frames, legs)
    contacts = {f"{part}.{side}": np.ones(frames, bool) for part in ("heel", "toe") for side in "LR"}
    return figure(joints, turns, contacts, seed, legs, 0.0, noise, 1)


def walking(time, legs=1.0, drop=0.0):
    """(joints, turns, contacts) at the times (f,) in seconds; turns: bone -> (f, 3, 3), from the T-pose."""
    phase, length = 2.0 * np.pi * time / CYCLE, (THIGH + SHANK) * legs
    pelvis = np.zeros((len(time), 3))
    stride = np.array([0.0, -STAIRS_STRIDE if drop else -STRIDE, -drop]) * legs
    pelvis[:, 0] = 0.02 * np.sin(phase)
    pelvis += (time / CYCLE)[:, None] * stride
    pelvis[:, 2] += ANKLE_HEIGHT + 0.935 * length + 0.05 - 0.012 * legs * np.cos(2.0 * phase - 0.6)
    pelvis[:, 2] -= 0.2 * drop * legs
    turns = {
        "pelvis": turn_z(0.09 * np.cos(phase)) @ turn_y(0.03 * np.sin(phase)),
        "chest": turn_z(-0.10 * np.cos(phase)) @ turn_x(np.full(len(time), 0.05)),
    }
    turns["head"] = turn_x(0.04 * np.sin(2.0 * phase))
    for side, sign, later in (("L", 1.0, 0.0), ("R", -1.0, np.pi)):
        swing = 0.42 * np.cos(phase + later)
        turns[f"upper_arm.{side}"] = turn_x(swing) @ turn_y(np.full(len(time), sign * 1.35))
        bend = turn_z(sign * (-0.35 + 0.15 * np.cos(phase + later)))
        turns[f"forearm.{side}"] = turns[f"upper_arm.{side}"] @ bend
    joints = trunk_and_arms(pelvis, turns)
    contacts = {}
    for side, sign, later in (("L", 1.0, 0.0), ("R", -1.0, 0.5)):
        hip = joints[f"hip.{side}"]
        ankle, turn, turns[f"toe.{side}"], on_ground = _foot(time / CYCLE + later, sign, legs, later, stride)
        turns[f"foot.{side}"], joints[f"toe.{side}"] = turn, ankle + turn @ TOE
        contacts[f"heel.{side}"], contacts[f"toe.{side}"] = on_ground
        knee = knee_between(hip, ankle, THIGH * legs, SHANK * legs)
        joints[f"knee.{side}"], joints[f"ankle.{side}"] = knee, ankle
        turns[f"thigh.{side}"] = leg_turn(hip - knee)
        turns[f"shank.{side}"] = leg_turn(knee - ankle)
    return joints, turns, contacts


def knee_angle(hip, knee, ankle):
    """(f,) degrees between thigh and shank, 0 where the leg is straight."""
    thigh, shank = knee - hip, ankle - knee
    cosine = (thigh * shank).sum(-1) / (np.linalg.norm(thigh, axis=-1) * np.linalg.norm(shank, axis=-1))
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def drop_samples(positions, share, rng, longest=20):
    """A copy with NaN in runs of 1 to `longest` samples, until `share` of all samples is missing."""
    result = positions.copy()
    frames, markers = positions.shape[:2]
    missing = np.zeros((frames, markers), bool)
    while missing.sum() < share * missing.size:
        length, marker = rng.integers(1, longest + 1), rng.integers(markers)
        begin = rng.integers(0, max(1, frames - length + 1))
        missing[begin : begin + length, marker] = True
    result[missing] = np.nan
    return result


def turn_x(angles):
    return _turns(angles, 1, 2)


def turn_y(angles):
    return _turns(angles, 2, 0)


def turn_z(angles):
    return _turns(angles, 0, 1)


def _turns(angles, first, second):
    angles = np.asarray(angles, float)
    result = np.broadcast_to(np.eye(3), (*angles.shape, 3, 3)).copy()
    result[..., first, first] = result[..., second, second] = np.cos(angles)
    result[..., second, first] = np.sin(angles)
    result[..., first, second] = -np.sin(angles)
    return result


def figure(joints, turns, contacts, seed, legs, gaps, noise, longest_gap):
    clean = markers_on(joints, turns, legs)
    rng = np.random.default_rng(seed)
    positions = clean + noise * rng.standard_normal(clean.shape)
    positions = drop_samples(positions, gaps, rng, longest_gap)
    angles = {side: knee_angle(*(joints[f"{joint}.{side}"] for joint in ("hip", "knee", "ankle"))) for side in "LR"}
    height = HEIGHT - (1.0 - legs) * (THIGH + SHANK)
    return Figure(LABELS, RATE_HZ, positions, clean, joints, contacts, angles, height)


def upright(frames, legs):
    bones = [f"{bone}.{side}" for side in "LR" for bone in ("upper_arm", "forearm", "thigh", "shank", "foot", "toe")]
    turns = {bone: np.broadcast_to(np.eye(3), (frames, 3, 3)) for bone in ["pelvis", "chest", "head", *bones]}
    pelvis = np.zeros((frames, 3))
    pelvis[:, 2] = ANKLE_HEIGHT + (THIGH + SHANK) * legs + 0.05
    joints = trunk_and_arms(pelvis, turns)
    for side in "LR":
        joints[f"knee.{side}"] = joints[f"hip.{side}"] - [0.0, 0.0, THIGH * legs]
        joints[f"ankle.{side}"] = joints[f"knee.{side}"] - [0.0, 0.0, SHANK * legs]
        joints[f"toe.{side}"] = joints[f"ankle.{side}"] + TOE
    return joints, turns


def trunk_and_arms(pelvis, turns):
    joints = {"pelvis": pelvis, "chest": pelvis + turns["pelvis"] @ [0.0, 0.0, 0.16]}
    joints["neck"] = joints["chest"] + turns["chest"] @ [0.0, 0.02, 0.37]
    joints["head"] = joints["neck"] + turns["head"] @ [0.0, -0.01, 0.05]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        joints[f"hip.{side}"] = pelvis + turns["pelvis"] @ [0.09 * sign, 0.0, -0.05]
        joints[f"shoulder.{side}"] = joints["chest"] + turns["chest"] @ [0.18 * sign, 0.0, 0.30]
        joints[f"elbow.{side}"] = joints[f"shoulder.{side}"] + turns[f"upper_arm.{side}"] @ [0.28 * sign, 0.0, 0.0]
        joints[f"wrist.{side}"] = joints[f"elbow.{side}"] + turns[f"forearm.{side}"] @ [0.25 * sign, 0.0, 0.0]
    return joints


def _foot(cycles, sign, legs, later, stride):
    """Ankle (f, 3), turns (f, 3, 3) of foot and toes and (heel on ground, toe on ground), `cycles` (f,) of its gait."""
    step, phase = np.floor(cycles), np.mod(cycles, 1.0)
    pitch = np.zeros(len(phase))
    for (begin, before), (end, after) in itertools.pairwise(PITCH):
        inside = (phase >= begin) & (phase < end)
        pitch[inside] = before + (after - before) * _smooth((phase[inside] - begin) / (end - begin))
    turn = turn_x(-np.radians(pitch))

    def flat_ankle(number):  # the pelvis is above the ankle of a flat foot a quarter into its cycle
        return [0.085 * sign, 0.0, ANKLE_HEIGHT] + (number + 0.27 - later)[:, None] * stride

    on_heel, on_toe = phase < FLAT, (phase >= FLAT) & (phase < TOE_OFF)
    by_heel = flat_ankle(step) + HEEL - turn @ HEEL
    by_toe = flat_ankle(step) + TOE - turn @ TOE
    strike = turn_x(np.full(len(phase), -np.radians(PITCH[0][1])))
    next_toe = flat_ankle(step + 1) + HEEL - strike @ HEEL + strike @ TOE  # where toes are when the heel strikes
    share = np.clip((phase - TOE_OFF) / (1.0 - TOE_OFF), 0.0, 1.0)
    toe = flat_ankle(step) + TOE + _smooth(share)[:, None] * (next_toe - flat_ankle(step) - TOE)
    toe[:, 2] += 0.05 * legs * (4.0 * share * (1.0 - share)) ** 3
    in_air = toe - turn @ TOE
    ankle = np.where(on_heel[:, None], by_heel, np.where(on_toe[:, None], by_toe, in_air))
    toes = turn_x(-np.radians(np.where(pitch < 0.0, pitch * _smooth(np.clip(3.0 * share, 0.0, 1.0)), pitch)))
    return ankle, turn, toes, (phase < HEEL_OFF, on_toe)


def _smooth(share):
    """0 to 1 with neither speed nor acceleration at the ends."""
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def knee_between(hip, ankle, thigh, shank):
    """(f, 3): the knee bends forward (-Y), in the plane of its leg."""
    leg = ankle - hip
    length = np.linalg.norm(leg, axis=1, keepdims=True)
    if (length >= thigh + shank).any():
        raise ValueError(f"a leg of {thigh + shank:.3f} m cannot reach {length.max():.3f} m")
    down = leg / length
    forward = np.array([0.0, -1.0, 0.0]) + down[:, 1:2] * down
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    along = (length**2 + thigh**2 - shank**2) / (2.0 * length)
    return hip + along * down + np.sqrt(thigh**2 - along**2) * forward


def leg_turn(up):
    """(f, 3, 3): turns +Z to `up`, the knee's axis stays in the plane across it."""
    up = up / np.linalg.norm(up, axis=1, keepdims=True)
    right = np.array([1.0, 0.0, 0.0]) - up[:, :1] * up
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return np.stack([right, np.cross(up, right), up], axis=2)


def markers_on(joints, turns, legs=1.0, centre=CENTRE_MARKERS, sides=SIDE_MARKERS):
    """(f, m, 3): markers on their bones, as in CENTRE_MARKERS, and as in SIDE_MARKERS on the left, then on the right;
    on legs, heights are shares of the bone's length."""
    hangs_on = {"thigh": "hip", "shank": "knee", "foot": "ankle", "toe": "toe"}
    hangs_on |= {"upper_arm": "shoulder", "forearm": "elbow"}
    stretch = {"thigh": THIGH * legs, "shank": SHANK * legs}
    columns = [joints[bone] + turns[bone] @ np.array(place) for bone, place in centre.values()]
    for side, sign in (("L", 1.0), ("R", -1.0)):
        for bone, place in sides.values():
            local = np.array(place) * [sign, 1.0, stretch.get(bone, 1.0)]
            if bone == "chest":
                columns.append(joints["chest"] + turns["chest"] @ local)
            else:
                columns.append(joints[f"{hangs_on[bone]}.{side}"] + turns[f"{bone}.{side}"] @ local)
    return np.stack(columns, axis=1)
