# SPDX-License-Identifier: GPL-3.0-or-later
"""What in-between keys weigh: products of polynomials along sliders, and the drivers that say them.

Polynomial `number` along a slider is 1 at the place of that number and 0 at the places before it. The places are a Leja
sequence: each is where the product of the distances to those before is largest, which keeps the polynomials small
between them (De Marchi, On Leja sequences, 2004). A product is named by its `orders`, ascending
((slider, number), ...).
`knots` are the places() of all sliders.
"""

import functools
import math

import numpy as np

#: No slider needs more: a turn by 180 degrees is met to 1e-6 by half as many.
MOST = 12

#: Places are rounded to so many decimals of a slider's range, so that drivers are short and mean the same.
DECIMALS = 4

#: All numbers of a product are no more than this: Blender cuts an expression at 255 characters.
MOST_TOGETHER = 14

VARIABLES = "abcdefghijklmnopqrstuvwxyz"


@functools.cache
def places(low, high):
    """The first MOST places, float64: 0, then 1 (or the end that is nearer), the ends, and those between."""
    low, high = min(low, 0.0), max(high, 0.0)
    found = [0.0, float(np.clip(1.0, low, high)) or low]
    finer = max(0, math.ceil(-math.log10(high - low)))
    tried = np.round(np.linspace(low, high, 2001), DECIMALS + finer)
    while len(found) < MOST:
        product = np.prod(np.abs(tried[:, None] - np.array(found)), axis=1)
        found.append(float(tried[product.argmax()]))
    return np.array(found)


def weight(knots, orders, settings):
    """(s,): the product with the sliders at each of `settings`, (s, k)."""
    result = np.ones(len(settings))
    for slider, number in orders:
        before = knots[slider][:number]
        result *= np.prod((settings[:, slider, None] - before) / (knots[slider][number] - before), axis=1)
    return result


def expression(knots, orders):
    """(text of a driver, [number of the slider of each of its variables]).

    Blender evaluates sums and products without Python, so such drivers are quick, and run where scripts may not.
    """
    scale, product = 1.0, []
    for variable, (slider, number) in zip(VARIABLES, orders, strict=False):
        before = knots[slider][:number]
        scale /= float(np.prod(knots[slider][number] - before))
        product += [variable if each == 0.0 else f"({variable}{-each:+.{DECIMALS + 2}g})" for each in before]
    return "*".join([f"{scale:.9g}", *product]), [slider for slider, _ in orders]


def label(names, knots, orders):
    """What a key is called: "Bend 0.5", "Bend 0.5 + Twist 1"."""
    return " + ".join(f"{names[slider]} {knots[slider][number]:.3g}" for slider, number in orders)
