# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixes hand to the solver: the shapes, and the calls that find the in-between keys."""

from ...errors import SceneError
from ..core import in_betweens
from . import mixed_keys, morphers
from .mix_reading import gather


class Mixing:
    """As widgets/background.py wants it: binds what is mixed. bind_input: the MixInput; binding: the Morpher."""

    changes = ""

    def __init__(self, mix_input):
        self.bind_input = mix_input
        self.binding = morphers.cached(mix_input)

    def read_triangles(self, _obj):
        pass

    def work(self, execution):
        """Steps (see solver/job.py) that bind. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from morphers.bind_steps(self.bind_input, execution)
            morphers.remember(self.bind_input, self.binding)

    def require_unchanged(self, obj, _reading):
        """@throws SceneError if the shape keys are others by now."""
        if mixed_keys.problem(obj) is None and gather(obj).revision == self.bind_input.revision:
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
        """Steps (see solver/job.py) to a Found. @throws MeanValueError."""
        yield from super().work(execution)
        mix_input = self.bind_input
        ranges = [(slider.low, slider.high) for slider in mix_input.sliders]
        search = in_betweens.found(ranges, mix_input.rest.shape, self.tolerance, self._most, mix_input.overlap)
        correction = None
        while True:
            try:
                values = search.send(correction)
            except StopIteration as end:
                return end.value
            mix = yield from morphers.solve_steps(self.binding, mix_input, values, execution)
            self.solved += 1
            correction = mix.positions - mix_input.linear(values)
