# SPDX-License-Identifier: GPL-3.0-or-later
"""What Bake Mix hands to the solver: the shapes, and the calls that find the in-between keys."""

from .. import mix_session
from ..bridge import mix_layers
from ..core.mixing import in_betweens
from ..errors import SceneError


class MixBaking:
    """In place of a Posing for operators/background.py. solved: mixes that were solved so far."""

    def __init__(self, mix_input, tolerance, most):
        self.input = mix_input
        self.tolerance = tolerance
        self.solved = 0
        self._most = most
        self._morpher = mix_session.cached(mix_input)

    def read_triangles(self, _obj):
        pass

    def work(self, execution):
        """Steps (see workers.job) to a core.mixing.in_betweens.Found. @throws MeanValueError."""
        mix_input = self.input
        if self._morpher is None:
            self._morpher = yield from mix_session.bind_steps(mix_input, execution)
        ranges = [(layer.low, layer.high) for layer in mix_input.layers]
        search = in_betweens.found(ranges, mix_input.rest.shape, self.tolerance, self._most, mix_input.overlap)
        correction = None
        while True:
            try:
                values = search.send(correction)
            except StopIteration as end:
                return end.value
            solved = yield from mix_session.solve_steps(self._morpher, mix_input, values, execution=execution)
            self.solved += 1
            correction = solved - mix_input.linear(values)

    def keep(self):
        mix_session.remember(self.input, self._morpher)

    def require_unchanged(self, obj, _reading):
        """@throws SceneError if the shape keys are others by now."""
        if mix_layers.problem(obj) is None and mix_layers.gather(obj).revision == self.input.revision:
            return
        raise SceneError(f"'{obj.name}' was changed while it was worked on, so the result is dropped. Try again")
