# SPDX-License-Identifier: GPL-3.0-or-later
"""Which markers of a take are on the body: no prop, no other person, nothing that nobody has cleared away.

A known name vouches for a marker, unless it is far away. What has none is on the body if it goes along with it and lies
near its skin.
"""

import numpy as np

from ...scene.core.point_sets import parts
from .landmarks import unknown_limbs

#: Two markers are on one body if their distance hardly changes and is never long, over the height of all; where names
#: do not tell, one of both is enough. Of so many frames, those with the least and the most of it do not count.
LOOSE, REACH, FRAMES, MOST = 0.06, 0.45, 100, (0.05, 0.95)
#: With as many known names, these are the body; else what most markers are on.
ENOUGH = 6
#: Over the body's height, how far from the skin a marker may lie: with posed limbs, without, and with a known name.
FAR, FAR_UNPOSED, FAR_NAMED = 0.08, 0.25, 0.5


def goes_along(positions, reference, is_known):
    """(m,) bool: which markers are known, or stay together with the body.

    positions  (f, m, 3), NaN where missing; reference  (m, 3); is_known  (m,) bool.
    """
    count, height, is_named = len(reference), np.ptp(reference[:, 2]), is_known.sum() >= ENOUGH
    positions, together = positions[:: max(1, len(positions) // FRAMES)], np.logical_and if is_named else np.logical_or
    linked = np.zeros((count, count), bool)
    for marker in range(count):
        apart = np.sort(np.linalg.norm(positions - positions[:, marker, None], axis=2), axis=0)  # NaN are last
        last = np.maximum((~np.isnan(apart)).sum(axis=0) - 1, 0)
        least, most = (apart[(share * last).round().astype(int), np.arange(count)] for share in MOST)
        linked[marker] = together(most - least < LOOSE * height, most < REACH * height)
    part = parts(np.argwhere(linked), count)
    return is_known | (np.isin(part, part[is_known]) if is_named else part == np.bincount(part).argmax())


def far(distances, landmarks, is_posed):
    """Numbers of markers farther from the skin than one on it can be; none if most are: then the alignment is wrong.

    distances  (m,) over the body's height; landmarks  m names or None; is_posed: limbs are in the mesh's pose.
    """
    reach = FAR if is_posed and not unknown_limbs(landmarks) else FAR_UNPOSED
    found = [row for row, name in enumerate(landmarks) if distances[row] > (FAR_NAMED if name else reach)]
    return found if 2 * len(found) < len(landmarks) else []
