# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of a recording in the time of the scene, and the stretches where they are missing."""

import numpy as np


def runs(flags):
    """r x 2 int: begin and end (the first after it) of each stretch of True in n bool `flags`."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(np.int8)))
    return edges.reshape(-1, 2)


def ramps(present, samples):
    """n float64: 0 where not `present` (n bool), 1 more than `samples` away from there, and in between growing by the
    same factor from sample to sample, 10^4 in all: of a spring it is the order of magnitude that is felt."""
    missing = np.flatnonzero(~present)
    if len(missing) == 0:
        return np.ones(len(present))
    at = np.arange(len(present))
    after = np.searchsorted(missing, at)
    away = np.minimum(
        np.abs(at - missing[np.minimum(after, len(missing) - 1)]), np.abs(at - missing[np.maximum(after - 1, 0)])
    )
    return np.where(present, 10.0 ** (-4.0 * (1.0 - np.minimum(away / (samples + 1.0), 1.0))), 0.0)


def changing_keys(values, frames):
    """(frames, values) of the keys, in straight lines from one to the next, of n `values`. No keys if all are 1."""
    if (values == 1.0).all():
        return frames[:0], values[:0]
    differs = np.concatenate([[True], values[1:] != values[:-1], [True]])
    wanted = differs[:-1] | differs[1:]
    return frames[wanted], values[wanted]
