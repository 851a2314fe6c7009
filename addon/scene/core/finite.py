# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions of vertices, checked."""

import numpy as np

from ... import wording
from ...errors import SceneError


def require_finite(positions, what):
    """@throws SceneError if n x 3 `positions` hold NaN or infinity."""
    broken = () if np.isfinite(positions).all() else np.flatnonzero(~np.isfinite(positions).all(axis=1))
    if len(broken):
        count = wording.vertices(len(broken))
        raise SceneError(f"{count} of the {what} (the first is {broken[0]}) are not numbers. Move or delete them")
