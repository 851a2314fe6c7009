# SPDX-License-Identifier: GPL-3.0-or-later
"""The figure of walking_figure stands, sits down on a box, and stands up again. Needs numpy alone.

Feet stand still and flat all the time; legs are exact, from the ankles up.
"""

import numpy as np

from . import walking_figure
from .walking_figure import ANKLE_HEIGHT, RATE_HZ, SHANK, THIGH, turn_x, turn_y, turn_z

#: Seconds: sits down from the first to the second, stands up from the third to the fourth.
DOWN_BEGIN, DOWN_END, UP_BEGIN, UP_END = 0.3, 1.7, 2.5, 3.9
FRAMES = 420
#: The box: its top, and from where to where along Y.
SEAT_HEIGHT, SEAT = 0.435, (0.22, 0.66)

#: Degrees at shares of sitting down: thighs back from upright, shanks forward, trunk forward.
SHARES = (0.0, 0.5, 1.0)
THIGHS, SHANKS, TRUNK = (7.0, 52.0, 89.0), (5.0, 17.0, 0.0), (2.0, 42.0, 4.0)


def take(frames=FRAMES, seed=0, gaps=0.0, noise=0.0, longest_gap=20):
    """The motion as a walking_figure.Figure."""
    joints, turns, contacts = sitting(np.arange(frames) / RATE_HZ)
    return walking_figure.figure(joints, turns, contacts, seed, 1.0, gaps, noise, longest_gap)


def sitting(time):
    """(joints, turns, contacts) at the times (f,) in seconds, as walking_figure.walking()."""
    down = _smooth((time - DOWN_BEGIN) / (DOWN_END - DOWN_BEGIN))
    share = down - _smooth((time - UP_BEGIN) / (UP_END - UP_BEGIN))
    thigh, shank, lean = (np.radians(_through(values, share)) for values in (THIGHS, SHANKS, TRUNK))
    hips = np.zeros((len(time), 3))
    hips[:, 1] = -SHANK * np.sin(shank) + THIGH * np.sin(thigh)
    hips[:, 2] = ANKLE_HEIGHT + SHANK * np.cos(shank) + THIGH * np.cos(thigh)
    turns = {"pelvis": turn_x(0.7 * lean - 0.12 * share), "chest": turn_x(lean), "head": turn_x(0.35 * lean)}
    _turn_arms(turns, share, lean)
    joints = walking_figure.trunk_and_arms(hips + turns["pelvis"] @ [0.0, 0.0, 0.05], turns)
    contacts = {}
    for side, sign in (("L", 1.0), ("R", -1.0)):
        ankle = np.broadcast_to([0.1 * sign, 0.0, ANKLE_HEIGHT], hips.shape)
        hip = joints[f"hip.{side}"]
        knee = walking_figure.knee_between(hip, ankle, THIGH, SHANK)
        joints[f"knee.{side}"], joints[f"ankle.{side}"] = knee, ankle
        turns[f"thigh.{side}"] = walking_figure.leg_turn(hip - knee)
        turns[f"shank.{side}"] = walking_figure.leg_turn(knee - ankle)
        turns[f"foot.{side}"] = turns[f"toe.{side}"] = turn_x(np.zeros(len(time)))
        joints[f"toe.{side}"] = ankle + walking_figure.TOE
        contacts[f"heel.{side}"] = contacts[f"toe.{side}"] = np.ones(len(time), bool)
    return joints, turns, contacts


def _turn_arms(turns, share, lean):
    """Arms hang; seated, the hands are over the knees."""
    for side, sign in (("L", 1.0), ("R", -1.0)):
        hang = turn_y(sign * (1.35 + 0.1 * share))
        turns[f"upper_arm.{side}"] = turn_x(-0.42 * share - 0.25 * lean) @ hang
        turns[f"forearm.{side}"] = turns[f"upper_arm.{side}"] @ turn_z(-sign * (0.3 + 0.22 * share))


def _smooth(share):
    """0 to 1 with neither speed nor acceleration at the ends."""
    share = np.clip(share, 0.0, 1.0)
    return share**3 * (10.0 - 15.0 * share + 6.0 * share**2)


def _through(values, share):
    """The parabola through three values at SHARES."""
    begin, middle, end = values
    bulge = middle - 0.5 * (begin + end)
    return begin + (end - begin) * share + 4.0 * bulge * share * (1.0 - share)
