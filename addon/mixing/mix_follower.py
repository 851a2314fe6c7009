# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixes the shape keys of one object while their sliders move.

Frames of a drag are drafts, each from the one before; when the sliders rest the mix is solved as one that depends on
their values alone. Shapes are read again once all is quiet, since Blender tells of a slider as it does of an edit.
"""

import numpy as np

from ..live.following import Following
from ..live.states import NotReadyError, State
from ..scene import object_model, subject
from .bridge import mix_layers, mix_session


class MixFollower(Following):
    """What is read is a MixInput, what is wanted the values of the sliders; a draft is SHOWN, a mix SETTLED."""

    CAUGHT_UP = frozenset({State.SETTLED, State.CHECKING})
    LOOKS_ALWAYS = True
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
        names = {key.name for key in mix_layers.taking_part(obj)} if keys else ()
        return np.array([key.value for key in keys.key_blocks if key.name in names]) if keys else np.empty(0)

    def __init__(self, obj, hears_itself):
        self._reading = None
        super().__init__(obj, hears_itself)

    @property
    def name_shown(self):
        return "Mixing"

    @property
    def reading_text(self):
        return "Mixing: reading the shape keys"

    def look_again(self):
        super().look_again()
        self._reading = self._signature = None

    def _nothing_known(self):
        super()._nothing_known()
        self._is_written = False

    def why_hidden(self, obj):
        return mix_layers.why_hidden(obj)

    def _why_it_gives_way(self, other_name):
        return (
            f"'{other_name}' has the same mesh and shapes it too. Turn Rotation-Aware Keys, or Live, off for one of "
            "them, or make the mesh a single user (Object > Relations > Make Single User)"
        )

    # Reading

    def _must_read(self, obj, _model):
        if self._input is not None and self._signature == mix_layers.signature(obj):
            return self._is_finishing and self._has_doubts(obj)
        self._reading = None
        return True

    def _has_doubts(self, obj):
        model = object_model.of(obj)
        return model.is_doubtful or self._seen != model.stamp

    def _require_ready(self, obj):
        if obj.mode != 'OBJECT' or obj.data.is_editmode:
            mode = subject.mode_name('EDIT' if obj.data.is_editmode else obj.mode)
            raise NotReadyError(f"'{obj.name}' is in {mode}. It goes on when you leave that")
        if obj.meanvalue.baked.target:
            raise NotReadyError("A bake plays in place of the mix. Press Remove Bake to mix live, or bake it anew")
        if mix_layers.made_names(obj):
            raise NotReadyError(
                "In-between keys stand for the mix already. Press Remove In-Betweens to mix live, or turn "
                "Rotation-Aware Keys off"
            )

    def _read_on(self, obj, seconds):
        if self._reading is None or self._dated != self._date(obj):
            self._begin_reading(obj)
        return self._reading.go_on(obj, seconds)

    def _begin_reading(self, obj):
        self._reading = mix_layers.MixReading(obj)
        self._dated = self._date(obj)

    def _date(self, obj):
        return mix_layers.signature(obj), object_model.of(obj).stamp.settings

    def _gather(self, obj):
        reading, self._reading = self._reading, None
        self._signature = mix_layers.signature(obj)
        object_model.of(obj).is_doubtful = False
        return reading.result(obj)

    def _is_same_input(self, first, second):
        return first.revision == second.revision

    def _cached_binding(self):
        return mix_session.cached(self._input)

    def _require_shown(self, obj):
        if self._is_written and not mix_layers.has_key(obj):
            self._is_written, self._shown, self._settled = False, None, None

    def _start_check(self, obj):
        self._begin_reading(obj)

    def _check_on(self, obj, seconds):
        if not self._read_on(obj, seconds):
            return False
        found = self._gather(obj)
        self._seen = object_model.of(obj).stamp
        self._take(obj, found)
        return True

    # Mixing

    def _read_targets(self, obj):
        self._require_shown(obj)
        return mix_layers.values(obj)

    def _is_same_target(self, first, second):
        return np.array_equal(first, second)

    def _bind_work(self, _obj):
        mix_input = self._input
        return lambda execution: mix_session.bind_steps(mix_input, execution)

    def _keep_binding(self, _obj, morpher):
        mix_session.remember(self._input, morpher)
        self._binding = morpher

    def _solving(self, obj):
        return self._mixing(is_draft=not self._is_quiet())

    def _settling(self, _obj):
        return self._mixing(is_draft=False)

    def _mixing(self, is_draft):
        morpher, mix_input, wanted = self._binding, self._input, self._wanted

        def work(execution):
            mix = yield from mix_session.solve_steps(morpher, mix_input, wanted, execution, is_draft)
            correction = mix.positions - mix_input.linear(wanted)
            return (mix_input.rest + correction).astype(np.float32), mix.seconds

        def collect(obj, outcome):
            shape, seconds = outcome
            if is_draft or not self.solve_seconds:
                self.solve_seconds = seconds  # what a frame of a drag takes
            self._shown = wanted
            self._settled = None if is_draft else wanted
            mix_layers.write(obj, shape)
            self._is_written = True
            self._expect_echo(obj)

        return work, collect
