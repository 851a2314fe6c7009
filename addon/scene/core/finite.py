# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions of vertices, checked."""

import numpy as np

from ... import wording
from ...errors import SceneError


def require_finite(positions, what):
    """@throws SceneError if n x 3 `positions` hold NaN or infinity."""
    broken = np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(broken):
        raise SceneError(
            f"{wording.vertices(len(broken))} of the {what} (the first is {broken[0]}) at places that are not numbers. "
            "Move or delete them"
        )
