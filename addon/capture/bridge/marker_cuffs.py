# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of skin that go along with limbs, for the object that the markers were matched to."""

from dataclasses import dataclass

import numpy as np

from ...scene.core import motion
from ..core import cuffs
from . import match_notes


@dataclass(frozen=True, eq=False)
class CuffMotion:
    """A ring of vertices (k,) that moves as one: centre (3,) at rest and centres (f, 3) in the object's space, turns
    (f, 3, 3) in the world, NaN where nobody knows; radius of the limb in the object's space."""

    name: str
    vertices: np.ndarray
    centre: np.ndarray
    radius: float
    centres: np.ndarray
    turns: np.ndarray


def find(given, markers, match):
    """([CuffMotion], sentences) of a bridge.match_input.MatchInput and its aligned Markers."""
    if not given.use_cuffs:
        return [], []
    surface = given.surface
    found, refused = cuffs.find_cuffs(
        markers.path, markers.reference, markers.landmarks, match.vertex, surface.vertices, surface.triangles
    )
    to_object = np.linalg.inv(surface.to_world)
    scale = np.cbrt(abs(np.linalg.det(to_object[:3, :3])))
    result = [
        CuffMotion(
            name=name,
            vertices=cuff.vertices,
            centre=motion.apply(to_object, cuff.centre),
            radius=scale * cuff.radius,
            centres=motion.apply(to_object, cuff.centres),
            turns=cuff.turns,
        )
        for cuff, name in zip(found, _names(found, markers.labels), strict=True)
    ]
    return result, match_notes.of_cuffs(result, refused, cuffs.ROLL)


def _names(found, labels):
    """A name for each, no two alike: a marker at a joint may be the first of two."""
    names = []
    for cuff in found:
        name, number = f"{cuff.segment or labels[cuff.markers[0]]} cuff", 1
        while (numbered := f"{name} {number}" if number > 1 else name) in names:
            number += 1
        names.append(numbered)
    return names
