# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrap without Blender: its calls of the native module."""

import meanvalue

from addon.wrapping.core.wrapping import Wrap


def bind(rest, triangles, anchors, strengths):
    task = meanvalue.start_bind(rest, triangles, anchors, strengths=strengths)
    yield task
    return task.result()


def solve(deformer, targets, weights=None, start=None, tolerance=None):
    task = deformer.start_solve(targets, weights=weights, start=start, tolerance=tolerance)
    yield task
    return task.result().vertices


def wrapped(given):
    wrap = Wrap(given)
    steps, shares = wrap.steps(bind, solve), []
    while True:
        try:
            next(steps).wait()
            shares.append(wrap.share)
        except StopIteration as end:
            assert shares == sorted(shares)
            return end.value
