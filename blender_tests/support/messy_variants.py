# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as artists' files have it: cut, with doubles, in unjoined halves, and worse."""

import numpy as np


def with_doubles(vertices, triangles, share=0.02, seed=3):
    """Every so many triangles get corners of their own: holes in the surface, and loose triangles in them."""
    chosen = np.random.default_rng(seed).random(len(triangles)) < share
    corners = triangles[chosen].ravel()
    result = triangles.copy()
    result[chosen] = (len(vertices) + np.arange(len(corners))).reshape(-1, 3)
    return np.concatenate([vertices, vertices[corners]]), result.astype(np.int32)


def cut(vertices, triangles, seed=4):
    """A band taken out across the longest extent, and faces here and there: open, in parts, with loose vertices."""
    axis = int(np.argmax(np.ptp(vertices, axis=0)))
    place = vertices[triangles].mean(axis=1)[:, axis]
    low, high = np.quantile(place, [0.6, 0.63])
    gone = ((place > low) & (place < high)) | (np.random.default_rng(seed).random(len(triangles)) < 0.01)
    return vertices, triangles[~gone]


def unjoined_halves(vertices, triangles, gap):
    """(vertices, triangles): what lies on one side of the middle, and its image, `gap` apart along an open seam."""
    middle = np.median(vertices[:, 0])
    kept = triangles[(vertices[triangles][:, :, 0] > middle).all(axis=1)]
    numbers, own = np.unique(kept, return_inverse=True)
    half = vertices[numbers].copy()
    own = own.reshape(-1, 3)
    edges = np.sort(np.stack([own, np.roll(own, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    single, uses = np.unique(edges, axis=0, return_counts=True)
    half[np.unique(single[uses == 1]), 0] = middle  # the seam
    half[:, 0] += 0.5 * gap
    image = half * [-1.0, 1.0, 1.0] + [2.0 * middle, 0.0, 0.0]
    return np.concatenate([half, image]), np.concatenate([own, own[:, ::-1] + len(half)]).astype(np.int32)
