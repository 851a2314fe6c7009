# SPDX-License-Identifier: GPL-3.0-or-later
"""From a take and a mesh to the handles that carry it: aligned, matched, mended, and where each vertex goes.

All of it is in the space of the world, where lengths mean something and there is an up; only what is written for the
object is in its own.
"""

from dataclasses import dataclass, field

import numpy as np

from ..bridge import marker_handles, mesh_arrays, shape_keys, takes
from ..core import fixed_points, motion, wording
from ..core.capture import filtering, gaps, matching, retargeting, skin
from ..errors import SceneError

#: Fewer points leave open how the markers are turned.
LEAST_PAIRS = 3


@dataclass(frozen=True, eq=False)
class Matched:
    """What match() found for m markers.

    names      of the markers
    vertices   (m,) distinct vertex indices
    offsets    (m, 3) from the vertex to the aligned marker at the reference frame, in the object's space
    distance   (m,) how far the marker is from the surface, in the world
    targets    (f, m, 3) where the vertices go, in the object's space; NaN where nobody knows
    frames     (f,) of the scene;  frame: that of the reference
    alignment  4 x 4, from where the markers are in the world to the object's space
    filled     {how, in words: share of the samples}
    """

    names: list
    vertices: np.ndarray
    offsets: np.ndarray
    distance: np.ndarray
    targets: np.ndarray
    frames: np.ndarray
    frame: float
    alignment: np.ndarray
    filled: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)


def match(obj):
    raise SceneError("stub")
def carry(obj,m): pass
def pick(obj,p,v): return []
