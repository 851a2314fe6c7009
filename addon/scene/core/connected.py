# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected parts."""

import numpy as np


def parts(edges, count):
    """n int: the lowest of each vertex' connected part of `count` vertices. Trees are joined at their roots, and made
    flat.

    edges  m x 2 vertex numbers.
    """
    return joined(np.arange(count), edges)


def joined(roots, edges):
    """As parts(), going on from what it gave for other edges; `roots` is written to."""
    while True:
        first, second = roots[edges[:, 0]], roots[edges[:, 1]]
        is_open = first != second
        if not is_open.any():
            return roots
        edges = edges[is_open]
        first, second = first[is_open], second[is_open]
        np.minimum.at(roots, np.maximum(first, second), np.minimum(first, second))
        while (roots[roots] != roots).any():
            roots[:] = roots[roots]
