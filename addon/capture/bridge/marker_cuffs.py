# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of skin that go along with limbs, for the object that the markers were matched to."""

from dataclasses import replace

import numpy as np

from ...scene.core import motion
from ..core import cuffs
from . import match_notes


def find(given, markers, match):
    """([core.cuffs.Cuff], sentences) of a bridge.match_input.MatchInput and its aligned Markers.

    Places and radii are in the object's space, turns in the world.
    """
    if not given.options.use_cuffs:
        return [], []
    surface = given.surface
    found, refused = cuffs.find_cuffs(
        markers.path, markers.reference, markers.landmarks, match.vertex, surface.vertices, surface.triangles
    )
    to_object = np.linalg.inv(surface.to_world)
    scale = np.cbrt(abs(np.linalg.det(to_object[:3, :3])))
    result = [
        replace(
            cuff,
            centre=motion.apply(to_object, cuff.centre),
            radius=scale * cuff.radius,
            centres=motion.apply(to_object, cuff.centres),
        )
        for cuff in found
    ]
    return result, match_notes.of_cuffs(result, refused, cuffs.ROLL)
