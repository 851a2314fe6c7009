# SPDX-License-Identifier: GPL-3.0-or-later
"""In-between keys against the mixes that they stand for, at random settings of the sliders."""

import itertools

import numpy as np
import pytest

from addon.mixing.core import in_betweens
from addon.mixing.core.in_betweens import MixInput
from addon.scene.core.key_shapes import Slider
from addon.solver.job import result_of
from blender_tests.support import bent_limb

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

REST, FACES = bent_limb.limb()
TRIANGLES = np.array([(face[0], *face[k : k + 2]) for face in FACES for k in range(1, len(face) - 1)], np.int32)
X = REST[:, 0]
THICK = REST * (1.0, 1.5, 1.5)
ROLLED = REST[:, [0, 2, 1]] * (1.0, -1.0, 1.0)

#: Vertex groups with soft edges: the last third, all but the first sixth, around the middle.
TAIL = np.clip((X - 3.5) / 0.5, 0.0, 1.0)
MOST = np.clip((X - 1.0) / 0.5, 0.0, 1.0)
MIDDLE = np.clip(1.0 - np.abs(X - 3.0) / 1.5, 0.0, 1.0)

#: For each slider its shape, its group or None, and its range.
MIXES = {
    "bend": [(bent_limb.bent(REST, 140), None, 0, 1)],
    "bend both ways": [(bent_limb.bent(REST, 60), None, -1, 1)],
    "bend too far": [(bent_limb.bent(REST, 60), None, 0, 2)],
    "bend, twist": [(bent_limb.bent(REST, 110), None, 0, 1), (bent_limb.twisted(REST, 120), None, 0, 1)],
    "thick tail, bend": [(THICK, TAIL, 0, 1), (bent_limb.bent(REST, 110), None, 0, 1)],
    "bent tail, twist": [(bent_limb.bent(REST, 110), TAIL, 0, 1), (bent_limb.twisted(REST, 120), None, 0, 1)],
    "most twisted, bend": [(bent_limb.twisted(REST, 120), MOST, 0, 1), (bent_limb.bent(REST, 110), None, 0, 1)],
    "most bent, tail twisted": [(bent_limb.bent(REST, 110), MOST, 0, 1), (bent_limb.twisted(REST, 120), TAIL, 0, 1)],
    "middle bent back, bend": [(bent_limb.bent(REST, -70), MIDDLE, 0, 1), (bent_limb.bent(REST, 90), None, 0, 1)],
    "three": [
        (bent_limb.bent(REST, 70), MIDDLE, 0, 1),
        (bent_limb.twisted(REST, 60), TAIL, 0, 1),
        (ROLLED, None, 0, 1),
    ],
}


def mix_of(sliders):
    named = {f"Slider {k}": each for k, each in enumerate(sliders)}
    rest = REST.astype(np.float32)
    return MixInput(
        sliders=tuple(Slider(name, low, high, "Basis", name) for name, (_, _, low, high) in named.items()),
        rest=rest,
        points={"Basis": rest, **{name: shape.astype(np.float32) for name, (shape, _, _, _) in named.items()}},
        masks={name: mask for name, (_, mask, _, _) in named.items() if mask is not None},
        triangles=TRIANGLES,
    )


def corrections(mix):
    """What the mix lacks in straight lines, as the add-on asks the solver for it."""
    shapes = np.array([mix.rest, *(mix.points[name] for name in mix.names)], np.float64)
    morpher = meanvalue.Morpher(shapes, mix.triangles)
    return lambda values: morpher.solve(mix.weights(values), parts=mix.parts).vertices - mix.mixed(values)


def farthest(offset):
    return np.linalg.norm(offset, axis=1).max()


def search(mix, correction, tolerance, most):
    ranges = [(slider.low, slider.high) for slider in mix.sliders]

    def solve(values):
        yield
        return correction(values)

    found = result_of(in_betweens.found(solve, ranges, tolerance, most, mix.common))
    knots = [in_betweens.places(*each) for each in ranges]

    def total(values):
        weights = (in_betweens.weight(knots, each.orders, values[None])[0] for each in found.shapes)
        return sum(weight * each.offset for weight, each in zip(weights, found.shapes, strict=True))

    return found, total


def ends(low, high):
    """Settings with each slider at one of its ends."""
    return np.array([*itertools.product(*zip(low, high, strict=True))], np.float64)


@pytest.mark.parametrize(("name", "share"), [*((name, 0.002) for name in MIXES if name != "three"), ("three", 0.01)])
def test_in_betweens_are_within_the_tolerance_at_50_random_settings_and_at_the_ends(name, share):
    mix = mix_of(MIXES[name])
    correction, tolerance = corrections(mix), share * mix.diagonal
    found, total = search(mix, correction, tolerance, 60)
    assert found.error <= tolerance
    low, high = np.array([(slider.low, slider.high) for slider in mix.sliders]).T
    settings = [*np.random.default_rng(3).uniform(low, high, (50, len(low))), *ends(low, high)]
    wanted = [correction(values) for values in settings]
    assert max(farthest(each) for each in wanted) > 5.0 * tolerance, "else there is nothing to be met"
    assert max(farthest(each - total(v)) for each, v in zip(wanted, settings, strict=True)) <= tolerance


@pytest.mark.parametrize("name", ["thick tail, bend", "bent tail, twist", "most twisted, bend", "three"])
def test_a_masked_slider_does_not_make_others_jump(name):
    """Second differences fall with the square of the step; at a jump they stay."""
    mix = mix_of(MIXES[name])
    correction = corrections(mix)

    def second_difference(steps, values_of):
        shapes = np.array([correction(values_of(share)) for share in np.linspace(0.0, 1.0, steps + 1)])
        return np.linalg.norm(np.diff(shapes, 2, axis=0), axis=2).max()

    for slider in range(len(mix.sliders)):
        values = np.full(len(mix.sliders), 0.6)
        for others in (0.6, 0.0):
            values_of = lambda share: np.where(np.arange(len(values)) == slider, share, others)  # noqa: B023, E731
            coarse, fine = (second_difference(steps, values_of) for steps in (20, 40))
            assert fine < max(0.4 * coarse, 1e-4 * mix.diagonal), (slider, others)


def test_with_no_masked_slider_moved_the_mix_is_that_of_the_others():
    sliders = MIXES["bent tail, twist"]
    alone = mix_of([(shape, None, low, high) for shape, _, low, high in sliders])
    mix = mix_of(sliders)
    np.testing.assert_array_equal(mix.weights([0.0, 0.3]), alone.weights([0.0, 0.3]))
    near = corrections(mix)([1e-7, 0.3])
    assert farthest(near - corrections(alone)([0.0, 0.3])) < 1e-4 * mix.diagonal


def test_a_group_of_all_vertices_alike_is_none():
    shape = bent_limb.bent(REST, 80)
    mix = mix_of([(shape, np.full(len(REST), 0.5), 0, 1), (THICK, TAIL, 0, 1)])
    assert mix.parts.tolist() == [2]
    np.testing.assert_allclose(mix.weights([0.8, 0.0]), [0.6, 0.4, 0.0])
    assert mix.weights([0.8, 0.1]).shape == (3, len(REST))


def test_many_keys_are_baked_by_few_solves():
    """Bumps all over a limb: each overlaps many of the others, and there are 28,680 pairs."""
    count, solves = 240, []
    rng = np.random.default_rng(2)
    far = [((REST - middle) ** 2).sum(axis=1) for middle in REST[rng.integers(len(REST), size=count)]]
    moves = [np.exp(-each / 0.1)[:, None] * rng.normal(0.0, 0.1, 3) for each in far]
    mix = mix_of([(REST + move, None, 0, 1) for move in moves])
    correction = corrections(mix)
    found, _total = search(mix, lambda values: solves.append(1) or correction(values), 0.002 * mix.diagonal, 60)
    assert 0 < len(found.shapes) <= 60 and len(solves) < 5 * count
