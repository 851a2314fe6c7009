# SPDX-License-Identifier: GPL-3.0-or-later
"""Connected parts."""

import numpy as np

from ...solver import native_loader


def parts(edges, count):
    """n int32, not to be written to: the lowest of each vertex' connected part of `count` vertices; edges m x 2."""
    nowhere, none = np.zeros((count, 3)), np.empty((0, 3), np.int32)
    return native_loader.module().SurfaceWays(nowhere, edges, none).parts
