# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys that stand for a mix, each driven by the sliders that it is a correction of."""

import numpy as np

from ... import ids
from ...scene import shape_keys
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
        _drive(obj.data.shape_keys, key, text, [names[slider] for slider in sliders])
        made.append(key.name)
    return made


def remove(obj):
    """Takes away what make() has made. Returns how many keys there were."""
    names = mixed_keys.in_between_names(obj)
    shape_keys.remove(obj, names)
    return len(names)


def _drive(keys, key, text, sliders):
    driver = key.driver_add("value").driver
    driver.type = 'SCRIPTED'  # Blender evaluates sums and products itself: no Python, no permission needed
    names = [*polynomials.VARIABLES[: len(sliders)], ids.MIX_MARK]  # the last is not in the expression
    for name, slider in zip(names, [*sliders, sliders[0]], strict=True):
        variable = driver.variables.new()
        variable.name = name
        variable.type = 'SINGLE_PROP'
        target = variable.targets[0]
        target.id_type, target.id = 'KEY', keys
        target.data_path = shape_keys.value_path(slider)
    driver.expression = text
