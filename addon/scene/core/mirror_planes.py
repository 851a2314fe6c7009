# SPDX-License-Identifier: GPL-3.0-or-later
"""Planes that mirror a mesh: (unit normal, distance from the origin along it)."""

import numpy as np


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
    following = edge_ends(face_corners, face_starts)
    lies_in = seam[face_corners] & seam[following]
    edges = np.sort(np.stack([face_corners[lies_in], following[lies_in]], axis=1), axis=1)
    if len(edges) == 0:
        return True  # single vertices touch the plane
    faces = np.unique(edges, axis=0, return_counts=True)[1]
    return bool(2 * np.count_nonzero(faces == 1) >= len(faces))


def needed(planes, twins, roi, anchors):
    """(planes, twins) of a BindInput without the planes whose seam nothing moves; (None, None) for none."""
    if planes is None:
        return None, None
    moves = roi.copy()
    moves[anchors] = True
    is_needed = [bool(moves[twin >= 0].any()) for twin in twins]
    return (planes[is_needed], twins[is_needed]) if any(is_needed) else (None, None)
