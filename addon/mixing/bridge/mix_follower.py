# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixes the shape keys of one object while their sliders move. A mix depends on their values alone."""

import numpy as np

from ...errors import SceneError
from ...live import roll
from ...live.following import Following
from ...scene import subject
from . import mixed_keys, morphers
from .mix_reading import MixReading


def turned(obj):
    """Rotation-Aware Keys were turned on or off. Without the key that turns the mix, keys add in straight lines."""
    if obj.meanvalue.mix.is_on:
        roll.turn_others_off(obj, MixFollower)
    elif subject.object_problem(obj) is None and not mixed_keys.is_mixed_by_another(obj):
        mixed_keys.remove(obj)
    obj.update_tag()


class MixFollower(Following):
    """What is read is a MixInput, what is wanted the values of the sliders."""

    READS = MixReading
    READS_AT_REST = True
    FOLLOWS = "shape keys"
    LABEL = "Rotation-Aware Keys"

    @staticmethod
    def asks_for(obj):
        return obj.meanvalue.mix.is_on

    @staticmethod
    def turn(obj, is_on):
        obj.meanvalue.mix.is_on = is_on

    @staticmethod
    def places(obj, depsgraph):
        """Where the sliders are, as numbers to be compared."""
        keys = obj.data.shape_keys.evaluated_get(depsgraph) if obj.data.shape_keys else None
        names = {key.name for key in mixed_keys.mixed(obj)} if keys else ()
        return np.array([key.value for key in keys.key_blocks if key.name in names]) if keys else np.empty(0)

    @staticmethod
    def why_hidden(obj):
        return mixed_keys.why_hidden(obj)

    def notes(self):
        return ()

    def _require_ready(self, obj):
        if obj.mode != 'OBJECT' or obj.data.is_editmode:
            mode = subject.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            raise SceneError(f"'{obj.name}' is in {mode}. It goes on when you leave that")
        if obj.meanvalue.baked.target:
            raise SceneError("A bake plays in place of the mix. Press Remove Bake to mix live, or bake it anew")
        if mixed_keys.in_between_names(obj):
            raise SceneError(
                "In-between keys stand for the mix already. Press Remove In-Betweens to mix live, or turn "
                "Rotation-Aware Keys off"
            )

    def _cached_binding(self, mix_input):
        return morphers.cached(mix_input)

    def _read_targets(self, obj):
        return mixed_keys.values(obj)

    def _is_same_target(self, first, second):
        return np.array_equal(first, second)

    def _bind_work(self, _obj):
        mix_input = self._input

        def collect(morpher):
            self._binding = morpher

        def work(execution):
            morpher = yield from morphers.bind_steps(mix_input, execution)
            return lambda _obj: collect(morpher)

        return work

    def _solve_work(self, _obj, **_options):
        morpher, mix_input, wanted = self._binding, self._input, self._wanted

        def collect(obj, shape, seconds):
            self.solve_seconds = seconds
            self._shown, self._is_settled = wanted, wanted is self._wanted
            self._write(obj, shape)

        def work(execution):
            mix = yield from morphers.solve_steps(morpher, mix_input, wanted, execution)
            shape = (mix_input.rest + (mix.positions - mix_input.linear(wanted))).astype(np.float32)
            return lambda obj: collect(obj, shape, mix.seconds)

        return work

    def _make_key(self, obj):
        mixed_keys.ensure_key(obj)
