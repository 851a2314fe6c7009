# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/mixing/core: few shapes that stand for a mix of sliders, and the drivers that say when."""

import math

import numpy as np
import pytest

from addon.mixing.core import in_betweens
from addon.mixing.core.in_betweens import MixInput
from addon.scene.core import motion, point_sets
from addon.scene.core.key_shapes import Slider
from addon.solver.job import result_of
from native.benchmarks.rigid import rotation_about

ARM = np.array([(0.5, 0.0, 0.0), (0.25, 0.0, 0.0), (0.0, 0.1, 0.0)])


def turned(angle):
    return ARM @ rotation_about((0, 0, 1), math.degrees(angle)).T


def corrections(angles):
    """What turning lacks in straight lines: sliders that each turn the arm by one of `angles`."""

    def correction(values):
        ends = sum(value * (turned(angle) - ARM) for value, angle in zip(values, angles, strict=True))
        return turned(sum(value * angle for value, angle in zip(values, angles, strict=True))) - ARM - ends

    return correction


def search(correction, ranges, tolerance, most=200, common=lambda _sliders: 1.0):
    """(Found, the settings that were asked for)."""
    asked = []

    def solve(values):
        asked.append(values)
        yield
        return correction(values)

    return result_of(in_betweens.found(solve, ranges, tolerance, most, common)), asked


def total(found, ranges, settings):
    """What the shapes that were found say, (s, n, 3)."""
    knots = [in_betweens.places(*each) for each in ranges]
    result = np.zeros((len(settings), *ARM.shape))
    for each in found.shapes:
        result += in_betweens.weight(knots, each.orders, settings)[:, None, None] * each.offset
    return result


def farthest(correction, found, ranges):
    settings = np.random.default_rng(7).uniform(*np.transpose(ranges), (200, len(ranges)))
    return np.linalg.norm([*map(correction, settings)] - total(found, ranges, settings), axis=2).max()


@pytest.mark.parametrize("low, high", [(0.0, 0.0005), (0.0, 1.0), (-1.0, 1.0), (-0.5, 2.0), (0.0, 0.5), (-1.0, 0.0)])
def test_each_polynomial_is_one_at_its_own_place_and_nothing_before(low, high):
    knots = in_betweens.places(low, high)
    assert knots[0] == 0.0 and len(set(knots)) == in_betweens.MOST
    assert knots.min() == low and knots.max() == high
    for number in range(1, in_betweens.MOST):
        values = in_betweens.weight([knots], ((0, number),), knots[: number + 1, None])
        np.testing.assert_allclose(values, [0.0] * number + [1.0], atol=1e-9)


def test_sliders_far_from_each_other_are_not_combined():
    correction = corrections([1.0])
    both = lambda values: correction(values[:1])  # noqa: E731  the second slider moves nothing
    found, _asked = search(both, [(0.0, 1.0)] * 2, 1e-3, common=lambda sliders: float(len(sliders) == 1))
    assert all(len(node.orders) == 1 for node in found.shapes)
    assert farthest(both, found, [(0.0, 1.0)] * 2) <= 1e-3


def test_where_straight_lines_are_near_enough_there_is_none():
    found, _asked = search(corrections([0.1]), [(0.0, 1.0)], 1.0)
    assert found.shapes == () and 0.0 < found.error < 1.0


def jumps(values):
    """Two sliders that turn, and jump where they pass each other."""
    return corrections([0.8, -0.5])(values) + 0.1 * (values[0] > values[1] + 0.05)


@pytest.mark.parametrize("most", [3, 10, 40])
def test_what_cannot_be_met_is_not_made_worse(most):
    """Polynomials through a jump swing; as many keys are kept as bring it nearest, and all that is left is told."""
    ranges = [(0.0, 1.0)] * 2
    found, asked = search(jumps, ranges, 1e-3, most=most)
    asked_first = np.array(asked[: in_betweens.JUDGING])
    wanted = np.array([*map(jumps, asked_first)])
    left = np.linalg.norm(wanted - total(found, ranges, asked_first), axis=2).max()
    assert len(found.shapes) <= most and len(asked) < 500
    assert 1e-3 < left <= found.error + 1e-9
    assert found.error <= np.linalg.norm(wanted, axis=2).max()


def test_expressions_say_what_the_polynomials_are():
    knots = [in_betweens.places(0.0, 1.0), in_betweens.places(-1.0, 1.0), in_betweens.places(-0.5, 2.0)]
    for orders in [((0, 1),), ((0, 4),), ((0, 2), (2, 3)), ((0, 3), (1, 2), (2, 5)), ((1, 11), (2, 11))]:
        text, sliders = in_betweens.expression(knots, orders)
        assert [number for number, _ in orders] == sliders
        settings = np.random.default_rng(3).uniform(-0.5, 1.0, (20, 3))
        for values, expected in zip(settings, in_betweens.weight(knots, orders, settings), strict=True):
            names = dict(zip(in_betweens.VARIABLES, values[sliders], strict=False))
            assert eval(text, {}, names) == pytest.approx(expected, rel=1e-5, abs=1e-5)


def test_blender_takes_the_longest_expressions():
    for low, high in ((-0.9137, 0.8791), (-0.00091, 0.00087)):
        for orders in (((0, 4), (1, 5), (2, 5)), ((0, 11), (1, 2), (2, 1)), ((0, 3), (1, 11))):
            assert len(in_betweens.expression([in_betweens.places(low, high)] * 3, orders)[0]) <= 255


def mix(mask=None):
    """mask: how much A counts at each vertex."""
    rest = np.zeros((3, 3), np.float32)
    shapes = {"A": np.tile((1.0, 0.0, 0.0), (3, 1)), "B": np.tile((0.0, 2.0, 0.0), (3, 1))}
    points = {"Basis": rest, **{name: shape.astype(np.float32) for name, shape in shapes.items()}}
    sliders = (Slider("A", 0.0, 1.0, "Basis", "" if mask is None else "Mask"), Slider("B", 0.0, 1.0, "Basis"))
    masks = {} if mask is None else {"Mask": mask}
    return MixInput(sliders, rest, points, masks, triangles=np.array([(0, 1, 2)], np.int32))


def test_weights_sum_to_one_and_the_linear_mix_is_blenders():
    weights = mix().weights([0.25, 0.5])
    np.testing.assert_array_equal(weights, [0.25, 0.25, 0.5])
    np.testing.assert_allclose(mix().mixed([0.25, 0.5]), np.tile((0.25, 1.0, 0.0), (3, 1)))
    masked = mix(np.array([0.0, 0.5, 1.0]))
    np.testing.assert_allclose(masked.weights([1.0, 0.5]).sum(axis=0), 1.0)
    np.testing.assert_allclose(masked.mixed([1.0, 0.5])[:, 0], [0.0, 0.5, 1.0])


def test_the_key_knows_the_shapes_and_the_revision_the_masks():
    assert mix().key == mix().key
    masked = mix(np.ones(3))
    assert masked.key == mix().key and masked.revision != mix().revision


def test_a_part_is_placed_by_its_border():
    """Whatever similarity it went through, its border comes back; what is inside stays as it is."""
    rng = np.random.default_rng(5)
    rest = rng.normal(size=(20, 3))
    other = rest.copy()
    other[12:] *= 1.7
    edges = np.array([(index, index + 1) for index in range(19)])
    mask = np.r_[np.zeros(6), 0.2, 0.4, 0.6, 0.8, np.ones(10)]
    at = point_sets.border(mask, edges)
    assert set(range(6, 10)) <= set(at)
    moved = 3.0 * other @ rotation_about((0, 0, 1), 60.0).T + (1.0, -2.0, 5.0)
    np.testing.assert_allclose(motion.placed(moved, rest, at), other, atol=1e-6)


def test_a_hard_border_is_that_of_the_edges():
    edges = np.array([(0, 1), (1, 2), (2, 3)])
    assert point_sets.border(np.array([0.0, 0.0, 1.0, 1.0]), edges).tolist() == [1, 2]


def test_what_is_nothing_at_the_end_of_a_slider_stays_so():
    """There the slider's own shape is shown, to the bit."""
    ranges = [(0.0, 1.0)] * 2
    found, _asked = search(corrections([1.2, 0.7]), ranges, 1e-3)
    assert not total(found, ranges, np.eye(2)).any()
