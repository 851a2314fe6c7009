# SPDX-License-Identifier: GPL-3.0-or-later
"""Points in one place."""

import numpy as np

#: A direction that neither edges nor planes of modelled meshes are at right angles to: along it they do not pile up.
_ALONG = np.array([0.5377, 0.3141, 0.7824])


def first_of_place(points, distance):
    """n int: for each of n x 3 points the lowest index of those that steps of at most `distance` lead to.

    Cost: that of sorting, and n for each point that is as near in one direction.
    """
    points = np.asarray(points, np.float64)
    first = np.arange(len(points))
    pairs = _near_pairs(points, distance)
    while len(pairs):
        before = first.copy()
        low = first[pairs].min(axis=1)
        np.minimum.at(first, pairs[:, 0], low)
        np.minimum.at(first, pairs[:, 1], low)
        first = first[first]
        if np.array_equal(first, before):
            break
    return first


def _near_pairs(points, distance):
    """p x 2: the pairs at most `distance` apart."""
    along = points @ (_ALONG / np.linalg.norm(_ALONG))
    order = np.argsort(along, kind="stable")
    along = along[order]
    reach = distance + 1e-14 * np.abs(along).max(initial=0.0)  # rounding
    begins, found, step = np.arange(len(points)), [np.empty((0, 2), int)], 0
    while len(begins):
        step += 1
        begins = begins[begins + step < len(points)]
        begins = begins[along[begins + step] - along[begins] <= reach]
        pairs = np.stack([order[begins], order[begins + step]], axis=1)
        near = ((points[pairs[:, 0]] - points[pairs[:, 1]]) ** 2).sum(axis=1) <= distance**2
        found.append(pairs[near])
    return np.concatenate(found)
