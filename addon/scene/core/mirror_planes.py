# SPDX-License-Identifier: GPL-3.0-or-later
"""Planes that mirror a mesh: (unit normal, distance from the origin along it)."""

import numpy as np

from ...solver import native_loader


def reflection(plane):
    """(3 x 3, 3 numbers): x goes to matrix x + vector. plane: unit normal and distance from the origin along it."""
    normal = np.asarray(plane[:3], np.float64)
    return np.eye(3) - 2.0 * np.outer(normal, normal), 2.0 * plane[3] * normal


def edge_ends(face_corners, face_starts):
    """Where the edge from each face corner goes to: the next corner of its face."""
    following = np.append(face_corners[1:], face_corners[:1])
    following[np.append(face_starts[1:], len(face_corners)) - 1] = face_corners[face_starts]
    return following


def is_a_border(seam, face_corners, face_starts):
    """Whether the mesh ends at the vertices of n bool `seam`: a half does. One that goes on beyond the plane, or does
    not reach it, has nothing to be joined to there."""
    if not seam.any():
        return False
    inside = np.count_nonzero(seam[face_corners] & seam[edge_ends(face_corners, face_starts)])
    borders = native_loader.module().border_edges(len(seam), face_corners, face_starts)
    # At least half of the edges: one that is no border is there twice. Or single vertices touch the plane.
    return bool(3 * np.count_nonzero(seam[borders].all(axis=1)) >= inside)


def needed(planes, twins, roi, anchors):
    """(planes, twins) of a BindInput without the planes whose seam nothing moves; (None, None) for none."""
    if planes is None:
        return None, None
    moves = roi.copy()
    moves[anchors] = True
    is_needed = [bool(moves[twin >= 0].any()) for twin in twins]
    return (planes[is_needed], twins[is_needed]) if any(is_needed) else (None, None)
