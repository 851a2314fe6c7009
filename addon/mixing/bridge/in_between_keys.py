# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys that stand for a mix, each driven by the sliders that it is a correction of."""

import numpy as np

from ... import ids
from ...scene import actions, shape_keys
from ..core import polynomials
from . import mixed_keys

#: A polynomial may go below 0 and above 1 between the places of its sliders.
FARTHEST = 10.0


def make(obj, mix_input, found):
    """Keys with their drivers for a Found, in place of what stood for a mix before."""
    remove(obj)
    shape_keys.remove(obj, mixed_keys.mix_names(obj))
    names = mix_input.names
    knots = [polynomials.places(slider.low, slider.high) for slider in mix_input.sliders]
    made = []
    for each in found.shapes:
        shape = (mix_input.rest + each.offset).astype(np.float32)
        key = shape_keys.add_shape(obj, polynomials.label(names, knots, each.orders), shape)
        key.slider_min, key.slider_max = -FARTHEST, FARTHEST
        text, sliders = polynomials.expression(knots, each.orders)
        others = [obj.data.shape_keys.key_blocks[names[slider]] for slider in sliders]
        variables = dict(zip(polynomials.VARIABLES, others, strict=False))
        actions.drive(key, {**variables, ids.MIX_MARK: others[0]}, text)  # the last is not in the expression
        made.append(key.name)
    return made


def remove(obj):
    """Takes away what make() has made. Returns how many keys there were."""
    names = mixed_keys.in_between_names(obj)
    shape_keys.remove(obj, names)
    return len(names)
