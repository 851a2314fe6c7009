# SPDX-License-Identifier: GPL-3.0-or-later
"""The expressions by which in-between keys are driven.

Blender evaluates sums and products without Python, so such drivers are quick, and run where scripts may not.
"""

from . import leja

#: Blender's own limit on an expression, without the closing zero.
LONGEST = 255

VARIABLES = "abcdefghijklmnopqrstuvwxyz"


def expression(knots, orders):
    """(text, [number of the slider of each variable]) of the weight of a node; knots, orders: as of in_betweens."""
    scale, product = 1.0, []
    for variable, (slider, number) in zip(VARIABLES, orders, strict=False):
        part, more = leja.factors(knots[slider], number, variable)
        scale *= part
        product += more
    return "*".join([f"{scale:.9g}", *product]), [slider for slider, _ in orders]


def fits(knots, orders):
    """Whether Blender takes the expression of a node."""
    return len(expression(knots, orders)[0]) <= LONGEST


def label(names, knots, orders):
    """What a node is called: "Bend 0.5", "Bend 0.5 + Twist 1"."""
    return " + ".join(f"{names[slider]} {knots[slider][number]:.3g}" for slider, number in orders)
