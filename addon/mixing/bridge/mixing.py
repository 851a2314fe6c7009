# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixes hand to the solver: the shapes, and the calls that find the in-between keys."""

from ...errors import SceneError
from ..core import in_betweens
from . import mix_layers, mix_session


class Mixing:
    """In place of a workers.posing.Posing: binds what is mixed. bind_input: the MixInput; binding: the Morpher."""

    changes = ""

    def __init__(self, mix_input):
        self.bind_input = mix_input
        self.binding = mix_session.cached(mix_input)

    def read_triangles(self, _obj):
        pass

    def work(self, execution):
        """Steps (see workers.job) that bind. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from mix_session.bind_steps(self.bind_input, execution)
            mix_session.remember(self.bind_input, self.binding)

    def require_unchanged(self, obj, _reading):
        """@throws SceneError if the shape keys are others by now."""
        if mix_layers.problem(obj) is None and mix_layers.gather(obj).revision == self.bind_input.revision:
            return
        raise SceneError(f"'{obj.name}' was changed while it was worked on, so the result is dropped. Try again")


class InBetweenSearch(Mixing):
    """Finds the in-between keys. solved: mixes that were solved so far."""

    def __init__(self, mix_input, tolerance, most):
        super().__init__(mix_input)
        self.tolerance = tolerance
        self.solved = 0
        self._most = most

    def work(self, execution):
        """Steps (see workers.job) to a core.mixing.in_betweens.Found. @throws MeanValueError."""
        yield from super().work(execution)
        mix_input = self.bind_input
        ranges = [(layer.low, layer.high) for layer in mix_input.layers]
        search = in_betweens.found(ranges, mix_input.rest.shape, self.tolerance, self._most, mix_input.overlap)
        correction = None
        while True:
            try:
                values = search.send(correction)
            except StopIteration as end:
                return end.value
            mix = yield from mix_session.solve_steps(self.binding, mix_input, values, execution)
            self.solved += 1
            correction = mix.positions - mix_input.linear(values)
