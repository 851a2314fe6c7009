# SPDX-License-Identifier: GPL-3.0-or-later
"""Wrap without Blender."""

from addon.wrapping.bridge.wrapping import Wrap


def wrapped(given):
    wrap = Wrap(given)
    steps, shares = wrap.work(None), []
    while True:
        try:
            next(steps).wait()
            shares.append(wrap.share)
        except StopIteration as end:
            assert shares == sorted(shares)
            return end.value
