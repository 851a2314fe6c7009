# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated sliders of a rotation-aware mix, as what can be baked: a rooms.Bakeable."""

import numpy as np

from ...errors import SceneError
from . import mixed_keys, morphers
from .mix_follower import MixFollower

solve_steps = morphers.solve_steps
is_on, turn = MixFollower.asks_for, MixFollower.turn


def is_meant(obj):
    baked = obj.meanvalue.baked
    return is_on(obj) or (bool(baked.target) and baked.was_mixed)


def bind(obj):
    return morphers.Mixing(mixed_keys.gather(obj))


def row(obj, mix_input):
    blocks = obj.data.shape_keys.key_blocks if obj.data.shape_keys else {}
    lost = next((name for name in mix_input.names if name not in blocks), None)
    if lost is not None:
        raise SceneError(f"there is no shape key '{lost}' any more")
    return np.array([blocks[name].value for name in mix_input.names], np.float64)


def shown_keys(obj):
    """The sliders, and the in-between keys that stand for the mix already."""
    keys = obj.data.shape_keys
    made = mixed_keys.in_between_names(obj) if keys is not None and keys.use_relative else ()
    in_betweens = [keys.key_blocks[name] for name in made]
    return [*mixed_keys.mixed(obj), *(key for key in in_betweens if key.value and not key.mute)]


def animated(obj):
    return [obj.data.shape_keys] if obj.data.shape_keys else []
