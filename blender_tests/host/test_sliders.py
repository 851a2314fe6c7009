# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of shape keys from the places of a few vertices, on a generated head with keys that overlap."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from native.benchmarks import rigid  # noqa: E402

SHAPES, ANCHORS = 16, 50


def sphere(count=1500):
    """(n, 3): points of a head of radius 10, evenly spread (Fibonacci)."""
    k = np.arange(count) + 0.5
    height, turn = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - height**2)
    return 10 * np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=1)


@pytest.fixture(scope="module")
def head():
    """(rest, shapes, anchors): each shape pushes one place of the skin some way."""
    rng = np.random.default_rng(1)
    rest = sphere()
    centers = rest[rng.choice(len(rest), SHAPES, replace=False)]
    ways = rng.normal(size=(SHAPES, 3))
    near = np.exp(-(np.linalg.norm(rest[None] - centers[:, None], axis=2) ** 2) / 30)
    shapes = rest + near[:, :, None] * ways[:, None]
    return rest, shapes, rng.choice(len(rest), ANCHORS, replace=False)


def mixed(head, values):
    rest, shapes, anchors = head
    return rest[anchors] + np.tensordot(values, shapes[:, anchors] - rest[anchors], 1)


def few_values(seed, count=4):
    rng = np.random.default_rng(seed)
    values = np.zeros(SHAPES)
    values[rng.choice(SHAPES, count, replace=False)] = rng.uniform(0.2, 1, count)
    return values


def moved(points, angle=20, offset=(3, -2, 5)):
    return points @ rigid.rotation_about([1, 2, 0.5], angle).T + offset


def motion(head, noise=0.0, frames=60):
    """(values (f, s), targets (f, k, 3)): two keys rise and fall while the head turns."""
    rng = np.random.default_rng(5)
    values = np.zeros((frames, SHAPES))
    values[:, 3] = 0.8 * np.sin(np.linspace(0, np.pi, frames)) ** 2
    values[:, 7] = 0.5 * np.sin(np.linspace(0, 2 * np.pi, frames)) ** 2
    targets = np.array([moved(mixed(head, of_frame), 0.3 * f) for f, of_frame in enumerate(values)])
    return values, targets + rng.normal(size=targets.shape) * noise


@pytest.mark.parametrize("seed", range(5))
def test_values_and_the_motion_of_the_head_come_back(head, seed):
    values = few_values(seed)
    found = meanvalue.SliderFit(*head).solve(moved(mixed(head, values)))
    assert np.abs(found.values - values).max() < 1e-3
    assert np.abs(found.residuals).max() < 1e-3
    assert not found.outliers.any()
    placed = mixed(head, found.values) @ found.transform[:3, :3].T + found.transform[:3, 3]
    assert np.abs(placed - moved(mixed(head, values))).max() < 1e-3
    assert np.allclose(found.transform[:3, :3] @ found.transform[:3, :3].T, np.eye(3), atol=1e-12)


def test_the_answer_turns_and_grows_with_the_input(head):
    rest, shapes, anchors = head
    targets = mixed(head, few_values(2)) + np.random.default_rng(0).normal(size=(ANCHORS, 3)) * 0.05
    found = meanvalue.SliderFit(*head).solve(targets)
    turned = meanvalue.SliderFit(*head).solve(moved(targets))
    grown = meanvalue.SliderFit(1e3 * rest, 1e3 * shapes, anchors).solve(1e3 * targets)
    assert np.abs(turned.values - found.values).max() < 1e-5
    assert np.abs(grown.values - found.values).max() < 1e-5


def test_values_stay_within_their_bounds(head):
    targets = mixed(head, 3 * few_values(1))
    lower, upper = np.full(SHAPES, -0.25), np.linspace(0.1, 1, SHAPES)
    upper[4] = lower[4] = 0.125  # a key that is locked
    found = meanvalue.SliderFit(*head, lower=lower, upper=upper).solve(targets).values
    assert (found >= lower).all()
    assert (found <= upper).all()
    assert found[4] == 0.125
    assert (found == upper).sum() > 1


def test_noise_moves_few_sliders(head):
    """A plain least-squares fit, even one that knows how the head turned, finds more in noise than there is."""
    rest, shapes, anchors = head
    basis = (shapes[:, anchors] - rest[anchors]).reshape(SHAPES, -1).T
    ours, plain = [], []
    for seed in range(20):
        values = few_values(seed, count=2)
        targets = mixed(head, values) + np.random.default_rng(seed).normal(size=(ANCHORS, 3)) * 0.1
        ours.append(meanvalue.SliderFit(*head).solve(moved(targets)).values - values)
        plain.append(np.linalg.lstsq(basis, (targets - rest[anchors]).ravel(), rcond=None)[0].clip(0, 1) - values)
    assert np.abs(ours).mean() < 0.8 * np.abs(plain).mean()


def test_weights_say_which_targets_count(head):
    values = few_values(8)
    targets = mixed(head, values)
    targets[:20] += np.random.default_rng(2).normal(size=(20, 3)) * 0.5
    weights = np.ones(ANCHORS)
    weights[:20] = 0.0
    fit = meanvalue.SliderFit(*head)
    assert np.abs(fit.solve(targets, weights).values - values).max() < 1e-3
    assert np.abs(fit.solve(targets).values - fit.solve(targets, np.full(ANCHORS, 5.0)).values).max() < 1e-9


def test_a_sequence_is_as_smooth_as_its_values(head):
    values, targets = motion(head, noise=0.1)
    fit = meanvalue.SliderFit(*head)
    smooth = fit.solve_sequence(targets).values
    alone = np.array([fit.solve(frame).values for frame in targets])
    assert np.abs(smooth - values).mean() < np.abs(alone - values).mean()
    jitter, of_truth, of_each = (np.abs(np.diff(of, 2, axis=0)).mean() for of in (smooth, values, alone))
    assert jitter < 0.5 * of_each
    assert jitter < 10 * of_truth


def test_threads_do_not_change_a_bit(head):
    _, targets = motion(head, noise=0.05)
    results = [meanvalue.SliderFit(*head, threads=threads).solve_sequence(targets) for threads in (1, 2, 5)]
    for other in results[1:]:
        assert np.array_equal(results[0].values, other.values)
        assert np.array_equal(results[0].transform, other.transform)


def test_a_whole_that_cannot_move_needs_one_target(head):
    rest, shapes, _ = head
    anchor = int(np.argmax(np.linalg.norm(shapes[0] - rest, axis=1)))
    fit = meanvalue.SliderFit(rest, shapes[:1], [anchor], can_move=False)
    found = fit.solve([0.4 * rest[anchor] + 0.6 * shapes[0, anchor]])
    assert found.values == pytest.approx([0.6], abs=1e-3)
    assert np.array_equal(found.transform, np.eye(4))


def test_shapes_that_the_anchors_do_not_see_or_tell_apart_are_named(head):
    rest, shapes, anchors = head
    far = rest.copy()
    far[np.setdiff1d(np.arange(len(rest)), anchors)[0]] += [0, 0, 5]
    rigidly = rest + np.array([0.5, 0, 0])
    twin = rest + 0.5 * (shapes[2] - rest)
    fit = meanvalue.SliderFit(rest, [*shapes, far, rigidly, twin], anchors)
    assert fit.unseen == (SHAPES, SHAPES + 1)
    assert fit.alike == ((2, SHAPES + 2),)
    assert fit.solve(mixed(head, few_values(1))).values[[SHAPES, SHAPES + 1]].tolist() == [0, 0]


def test_work_runs_beside_the_interpreter_and_can_be_cancelled(head):
    _, targets = motion(head)
    fit = meanvalue.SliderFit(*head)
    assert np.array_equal(fit.start_solve_sequence(targets).result().values, fit.solve_sequence(targets).values)
    execution = meanvalue.Execution()
    execution.cancel()
    with pytest.raises(meanvalue.Cancelled):
        fit.solve_sequence(targets, execution=execution)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda rest, shapes, anchors: (rest, shapes[:, :-1], anchors), r"shapes\[0\].*1499"),
        (lambda rest, shapes, anchors: (rest, shapes[:0], anchors), "no shapes"),
        (lambda rest, shapes, anchors: (rest, [*shapes, np.full_like(rest, np.nan)], anchors), r"shapes\[16\]"),
        (lambda rest, shapes, anchors: (rest, [rest, rest + 1], anchors), "no shape moves"),
        (lambda rest, shapes, anchors: (rest, shapes, [0, 1, len(rest)]), r"anchors\[2\]"),
        (lambda rest, shapes, anchors: (rest, shapes, []), "anchors"),
    ],
)
def test_bad_models_are_named(head, change, named):
    with pytest.raises(meanvalue.InvalidInput, match=named):
        meanvalue.SliderFit(*change(*head))


@pytest.mark.parametrize(
    ("bounds", "named"),
    [({"lower": 2.0}, r"lower\[0\]"), ({"upper": [1, 2]}, "upper"), ({"upper": np.nan}, r"upper\[0\]")],
)
def test_bad_bounds_are_named(head, bounds, named):
    with pytest.raises(meanvalue.InvalidInput, match=named):
        meanvalue.SliderFit(*head, **bounds)


def test_bad_targets_are_named(head):
    fit = meanvalue.SliderFit(*head)
    targets = mixed(head, few_values(0))
    few = np.full_like(targets, np.nan)
    few[:2] = targets[:2]
    for arguments, named in (
        ((targets[:-1],), "targets"),
        ((few,), "3 or more"),
        ((targets, np.full(ANCHORS, -1.0)), r"weights\[0\]"),
        ((targets, np.ones(3)), "weights"),
    ):
        with pytest.raises(meanvalue.InvalidInput, match=named):
            fit.solve(*arguments)
    with pytest.raises(meanvalue.InvalidInput, match="start"):
        fit.solve(targets, start=[0.0])
    with pytest.raises(meanvalue.InvalidInput, match="3 or more"):
        fit.solve_sequence([few, few])
    for weights in (np.ones((ANCHORS, 2)), np.full((2, ANCHORS), 1e308)):
        with pytest.raises(meanvalue.InvalidInput, match="weights"):
            fit.solve_sequence([targets, targets], weights)
    with pytest.raises(meanvalue.InvalidInput, match="targets has coordinates"):
        fit.solve(1e100 * targets)
    with pytest.raises(meanvalue.InvalidInput, match="no frames"):
        fit.solve_sequence(np.empty((0, ANCHORS, 3)))


def test_a_steady_drag_follows_its_target_and_changes_values_no_faster(head):
    """One that is alone against many is no outlier, and keys that fit alike share what there is to do."""
    rest, shapes, anchors = head
    fit = meanvalue.SliderFit(*head, can_move=False)
    dragged = int(np.argmax(np.linalg.norm(shapes[0, anchors] - rest[anchors], axis=1)))
    way = (shapes[0] - rest)[anchors[dragged]]
    weights = np.full(ANCHORS, 0.02)
    weights[dragged] = 1.0
    found = []
    for share in np.linspace(0, 1, 101):
        targets = rest[anchors].copy()
        targets[dragged] += share * way
        found.append(fit.solve(targets, weights, steady=True))
    values = np.array([each.values for each in found])
    assert np.abs(values[0]).max() < 1e-12
    assert np.abs(np.diff(values, axis=0)).max() < 0.03
    assert np.linalg.norm(found[-1].residuals[dragged]) < 0.7 * np.linalg.norm(way)
    assert not found[-1].outliers.any()
    backwards = fit.solve(targets, weights, steady=True, start=np.ones(SHAPES)).values
    assert np.abs(backwards - values[-1]).max() < 1e-8


def test_a_steady_answer_goes_along_with_the_whole(head):
    values = few_values(3)
    fit = meanvalue.SliderFit(*head)
    still, turned = (fit.solve(t, steady=True) for t in (mixed(head, values), moved(mixed(head, values))))
    assert np.abs(still.values - turned.values).max() < 1e-2
    assert np.abs(still.residuals).max() < 0.1 * np.abs(mixed(head, values) - mixed(head, 0 * values)).max()
