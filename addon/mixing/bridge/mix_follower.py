# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixes the shape keys of one object while their sliders move. A mix depends on their values alone.
What is animated of them can be baked: this is a rooms.Bakeable."""

import collections
import functools
import re

import numpy as np

from ...errors import ChangedMeanwhileError, SceneError, SolverError
from ...live import roll
from ...live.following import Following
from ...scene import actions, shape_keys, subject
from ...solver import native_loader, session
from ..core import in_betweens
from . import mixed_keys

REFUSED_SHAPES = "The solver cannot mix these shape keys: {}"


#: positions n x 3 float64; seconds that the solver took.
Mix = collections.namedtuple("Mix", "positions converged seconds")


def bind_steps(mix_input, execution):
    """Steps (see solver/job.py) to a native Morpher, which is kept. @throws MeanValueError."""
    whole = mix_input.whole
    shapes = [whole.start(shape) for shape in (mix_input.rest, *(mix_input.points[name] for name in mix_input.names))]
    try:
        morpher = yield from session.steps(
            native_loader.module().start_bind_morph,
            np.array(shapes),
            mix_input.triangles,
            execution=execution,
            refused=REFUSED_SHAPES,
        )
    except SolverError as error:
        names = ["the rest shape", *(f"'{name}'" for name in mix_input.names)]
        raise SolverError(re.sub(r"shapes\[(\d+)\]", lambda found: names[int(found[1])], str(error))) from error
    session.cache.put(mix_input.key, morpher, int(morpher.report.bytes))
    return morpher


def solve_steps(morpher, mix_input, values, execution=None):
    """Steps to the Mix with the sliders at `values`, (k,): where one shape alone is wanted, that to the bit.
    @throws SolverError, CancelledError."""
    weights = mix_input.weights(values)
    if weights.ndim == 1 and np.count_nonzero(weights) == 1 and weights.max() == 1.0:
        shape = mix_input.points[mix_input.names[weights.argmax() - 1]] if weights[0] == 0.0 else mix_input.rest
        return Mix(shape.astype(np.float64), True, 0.0)
    solution = yield from session.steps(
        morpher.start_solve,
        weights if weights.ndim == 1 else mix_input.whole.values(weights),
        parts=mix_input.parts,
        execution=execution,
        refused=REFUSED_SHAPES,
    )
    return Mix(
        positions=mix_input.whole.cut_back(session.finite(solution.vertices, "Move the sliders closer to 0")),
        converged=bool(solution.converged),
        seconds=float(solution.timings["total"]),
    )


class Mixing:
    """As widgets/background.py wants it: binds what is mixed. bind_input: the MixInput; binding: the Morpher."""

    def __init__(self, mix_input):
        self.bind_input = mix_input
        self.binding = session.cache.get(mix_input.key)

    def record(self, _obj):
        """The file keeps no binding of a mix."""

    def work(self, execution):
        """Steps (see solver/job.py) that bind. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from bind_steps(self.bind_input, execution)

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if the shape keys are others by now."""
        if mixed_keys.problem(obj) is None and mixed_keys.gather(obj).revision == self.bind_input.revision:
            return
        raise ChangedMeanwhileError(obj.name)


#: In-between keys that are made at most.
MOST_KEYS = 60


class InBetweenSearch(Mixing):
    """Finds the in-between keys. solved: mixes that were solved so far."""

    def __init__(self, mix_input, tolerance):
        super().__init__(mix_input)
        self.tolerance = tolerance
        self.solved = 0

    def work(self, execution):
        """Steps (see solver/job.py) to a Found. @throws MeanValueError."""
        yield from super().work(execution)
        mix_input = self.bind_input
        ranges = [(slider.low, slider.high) for slider in mix_input.sliders]

        def correction(values):
            mix = yield from solve_steps(self.binding, mix_input, values, execution)
            self.solved += 1
            return mix.positions - mix_input.mixed(values)

        return (yield from in_betweens.found(correction, ranges, self.tolerance, MOST_KEYS, mix_input.common))


def turned(obj):
    """Rotation-Aware Keys were turned on or off. Without the key that turns the mix, keys add in straight lines."""
    if obj.meanvalue.mix.is_on:
        roll.turned_on(obj, MixFollower)
    elif subject.object_problem(obj) is None:
        others = shape_keys.sharing(obj)
        if not any(other.meanvalue.mix.is_on for other in others):
            shape_keys.remove(obj, mixed_keys.mix_names(obj))
    obj.update_tag()


class MixFollower(Following):
    """What is read is a MixInput, what is wanted the values of the sliders."""

    READS = mixed_keys.READING
    READS_AT_REST = True
    BUSY_MODES = {'EDIT', 'SCULPT', 'VERTEX_PAINT', 'WEIGHT_PAINT', 'TEXTURE_PAINT', 'PARTICLE_EDIT'}
    FOLLOWS, AND_EXPORTS = "shape keys", ""
    LABEL = "Rotation-Aware Keys"

    asks_for = staticmethod(lambda obj: obj.meanvalue.mix.is_on)
    is_animated = staticmethod(lambda obj: obj.data.shape_keys is not None and actions.is_animated(obj.data.shape_keys))
    why_hidden = staticmethod(mixed_keys.why_hidden)
    _cached_binding = staticmethod(lambda mix_input: session.cache.get(mix_input.key))
    _is_same_target = staticmethod(np.array_equal)
    _make_key = staticmethod(mixed_keys.make_key)

    @staticmethod
    def turn(obj, is_on):
        obj.meanvalue.mix.is_on = is_on

    def notes(self):
        return ()

    def _read_targets(self, obj):
        return row(obj, self._input)

    def _require_ready(self, obj):
        super()._require_ready(obj)
        if obj.meanvalue.baked.target:
            raise SceneError("A bake plays in place of the mix. Press Remove Bake to mix live, or bake it anew")
        if mixed_keys.in_between_names(obj):
            raise SceneError("In-between keys stand for the mix already. Press Remove In-Betweens to mix live")

    def _bind_work(self, _obj):
        def collect(_obj, morpher):
            self._binding = morpher

        return functools.partial(bind_steps, self._input), collect

    def _solve_work(self, _obj, **_options):
        morpher, mix_input, wanted = self._binding, self._input, self._wanted

        def collect(obj, mix):
            self.solve_seconds = mix.seconds
            self._shown, self._is_settled = wanted, wanted is self._wanted
            self._write(obj, (mix_input.rest + (mix.positions - mix_input.mixed(wanted))).astype(np.float32))

        return functools.partial(solve_steps, morpher, mix_input, wanted), collect


is_on, turn = MixFollower.asks_for, MixFollower.turn


def is_meant(obj):
    baked = obj.meanvalue.baked
    return is_on(obj) or (bool(baked.target) and baked.was_mixed)


def bind(obj):
    return Mixing(mixed_keys.gather(obj))


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
