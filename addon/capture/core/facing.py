# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a body looks, and where the skin under each landmark of its limbs does.

Of legs that follows from the way that the body looks. Arms are in any pose, so there it follows from the hand: how a
forearm is rolled is seen by nothing else of its shape.
"""

import numpy as np

from ...scene.core.motion import unit
from . import landmarks as places

#: (outward to its side, forward).
LEG = {"knee": (1, 0), "knee.inner": (-1, 0), "ankle": (1, 0), "ankle.inner": (-1, 0), "heel": (0, -1)}
#: (the way of the back of the hand, the way of the thumb), for arms at rest. A single marker of the wrist is put where
#: it is seen and stays: on its back. Their lengths tell how sure that is: elbows bend about an axis that is about half
#: a right angle off that of the hand.
ARM = {
    "upper_arm": (0.3, 0), "elbow": (0.2, -0.2), "elbow.inner": (-0.2, 0.2), "forearm": (1, 0), "wrist": (1, 0),
    "wrist.thumb": (0, 1), "wrist.little": (0, -1), "hand": (1, 0), "hand.thumb": (0, 1),
}  # fmt: skip
#: What is hand: so near to the tips, over the body's height. It is flat, to be told from a fist, where it is so much
#: wider than thick (standard deviations); and it has at least so many samples.
HAND, FLAT, LEAST = 0.085, 1.25, 30


def forward(markers, names):
    """(2,) where the body looks, seen from above: across from right to left of the places that both sides have, those
    of the trunk if there are any, since legs may be in a step; None without such places.

    markers  (m, 3) without NaN; names  m landmarks or None.
    """
    at, heights = {name: number for number, name in enumerate(names)}, places.heights_of(names)
    pairs = [(left, at[name[:-1] + "R"]) for name, left in at.items()
             if places.side_of(name) == "L" and name[:-1] + "R" in at and heights[left] > 0.01]  # fmt: skip
    trunk = [pair for pair in pairs if heights[pair[0]] > 0.5]
    across = sum((markers[left] - markers[right] for left, right in trunk or pairs), np.zeros(3))
    return np.array([across[1], -across[0]]) if across[:2].any() else None


def walks_backward(markers, names):
    """Whether feet point the other way than the names of both sides tell, as of a mirrored capture; as forward()."""
    looks, feet = forward(markers, names), []
    for side in "LR":
        toes, heel = ([k for k, name in enumerate(names) if places.side_of(name) == side and name.startswith(parts)]
                      for parts in ("toe", ("heel", "ankle")))  # fmt: skip
        feet += [markers[toes].mean(axis=0) - markers[heel].mean(axis=0)] if toes and heel else []
    return looks is not None and bool(feet) and max(foot[:2] @ looks for foot in feet) < 0.0


def of_limb(names, ways, first, second):
    """(m, 3), at most unit: where the skin under each marker looks; 0 where that is not known. ways  ARM or LEG, whose
    two columns are along the unit vectors first, second (3,)."""
    shares = np.array([ways.get((name or "")[:-2], (0.0, 0.0)) for name in names])
    return shares @ np.stack([first, second])


def hand_of(skin, from_tip, side, height, looks):
    """Unit vectors (3,) to the back and to the thumb's side of the hand at the end of the skin (s, 3) of an arm of side
    "L" or "R", or None where it is no flat hand.

    The thumb is where it is in every usual pose, palms down, inward or forward: ahead or up. from_tip  (s,) along
    the skin from the finger tips; height of the body; looks  (2,) of `forward()`, or None.
    """
    is_hand = from_tip < HAND * height
    points, away = skin[is_hand], from_tip[is_hand]
    if looks is None or len(points) < LEAST:
        return None
    _, spread, axes = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    if spread[1] < FLAT * spread[2]:
        return None
    along = points[away < np.quantile(away, 0.2)].mean(axis=0) - points[away > np.quantile(away, 0.8)].mean(axis=0)
    thumb = unit(np.cross(axes[2], along))
    thumb = thumb if thumb @ np.append(unit(looks), 1.0) > 0.0 else -thumb
    back = unit(np.cross(thumb, along))
    return (back if side == "L" else -back), thumb
