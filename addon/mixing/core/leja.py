# SPDX-License-Identifier: GPL-3.0-or-later
"""Polynomials along one slider, each of which is 1 at a place of its own and 0 at the places before it.

The places are a Leja sequence: each is where the product of the distances to those before is largest, which keeps the
polynomials small between them. A sum of n of them goes through any n values, and one more leaves the others as they
are. (De Marchi, On Leja sequences, 2004; Chkifa, Cohen, Schwab, High-dimensional adaptive sparse polynomial
interpolation, 2014.)
"""

import functools

import numpy as np

#: No slider needs more: a turn by 180 degrees is met to 1e-6 by half as many.
MOST = 12

#: Places are rounded, so that drivers are short and mean the same.
DECIMALS = 4


@functools.cache
def places(low, high):
    """The first MOST places, float64: 0, then 1 (or the end that is nearer), the ends, and those between."""
    low, high = min(low, 0.0), max(high, 0.0)
    found = [0.0, float(np.clip(1.0, low, high)) or low]
    tried = np.round(np.linspace(low, high, 2001), DECIMALS)
    while len(found) < MOST:
        product = np.prod(np.abs(tried[:, None] - np.array(found)), axis=1)
        found.append(float(tried[product.argmax()]))
    return np.array(found)


def value(knots, number, at):
    """The polynomial `number` at the place `at`; knots: as of places()."""
    before = knots[:number]
    return float(np.prod((at - before) / (knots[number] - before)))


def factors(knots, number, variable):
    """(scale, ["a", "(a-1)", ...]): value() as factors of a driver's expression."""
    before = knots[:number]
    scale = 1.0 / float(np.prod(knots[number] - before))
    return scale, [variable if each == 0.0 else f"({variable}{-each:+.{DECIMALS + 2}g})" for each in before]
