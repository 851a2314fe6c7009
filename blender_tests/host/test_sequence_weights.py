# SPDX-License-Identifier: GPL-3.0-or-later
"""Anchors that count less for a while, in single solves and along a clip."""

import numpy as np
import pytest

from addon.scene.core import sample_times
from blender_tests.host.test_sequences import bar, diagonal, meanvalue, swing


@pytest.fixture(scope="module")
def soft():
    """A bar by twelve soft single vertices, and its targets swung."""
    points, faces, anchors, pieces = bar(2600)
    chosen = np.linspace(0, len(points) - 1, 12).astype(np.int32)
    posed = meanvalue.Deformer(points, faces, anchors, handles=pieces).solve_sequence(
        swing(points, anchors, pieces, 24)
    )
    targets = posed.vertices[:, chosen].astype(np.float64)
    return points, faces, chosen, targets


def bind(soft, strength=1.0, without=()):
    points, faces, chosen, _ = soft
    kept = np.setdiff1d(np.arange(len(chosen)), without)
    return meanvalue.Deformer(points, faces, chosen[kept], strengths=np.full(len(kept), strength)), kept


@pytest.mark.parametrize("strength", [0.1, 1.0, 100.0])
def test_an_anchor_of_weight_0_is_as_if_it_were_none(soft, strength):
    points, _, chosen, targets = soft
    freed = [3, 7, 8]
    whole, _ = bind(soft, strength)
    less, kept = bind(soft, strength, freed)
    weights = np.ones(len(chosen))
    weights[freed] = 0.0
    holed = targets[20].copy()
    holed[freed] = np.nan
    shape = whole.solve(holed, weights=weights, tolerance=1e-6).vertices
    expected = less.solve(targets[20][kept], tolerance=1e-6).vertices
    assert np.abs(shape - expected).max() < 2e-3 * diagonal(points)


def test_a_smaller_weight_lets_an_anchor_give_way_more(soft):
    _, _, chosen, targets = soft
    deformer, _ = bind(soft, 1.0)
    pulled = targets[0].copy()
    pulled[5] += 0.1
    distances = []
    for weight in (1.0, 0.5, 0.1, 0.01):
        weights = np.ones(len(chosen))
        weights[5] = weight
        shape = deformer.solve(pulled, weights=weights, tolerance=1e-6).vertices
        distances.append(np.linalg.norm(shape[chosen[5]] - pulled[5]))
    assert distances == sorted(distances)
    assert distances[0] < 0.5 * distances[-1]


def test_anchors_come_and_go_along_a_clip(soft):
    """Nothing stays of a gap once it is over, and in it the shape is that of the other anchors."""
    points, _, _, targets = soft
    deformer, _ = bind(soft)
    weights = np.ones(targets.shape[:2])
    weights[5:12, 4] = 0.0
    weights[9:15, 6] = 0.0
    holed = np.where(weights[..., None] > 0.0, targets, np.nan)
    # Without overlap: nothing is spread, each frame is its solve.
    result = deformer.solve_sequence(holed, weights=weights, tolerance=1e-6, overlap=0)
    complete = deformer.solve_sequence(targets, tolerance=1e-6, overlap=0)
    assert result.errors == ()
    assert np.isfinite(result.vertices).all()
    off = np.abs(result.vertices - complete.vertices).max(axis=(1, 2)) / diagonal(points)
    assert off[:5].max() < 1e-5
    assert off.max() < 0.05
    assert off[18:].max() < 3e-3


@pytest.mark.parametrize("vertices", [300, 3000])
def test_a_part_whose_anchors_all_count_nothing_is_where_a_solve_from_rest_has_it(vertices):
    """Also beside another part that goes on, and in meshes with coarse levels, which go on from the frame before."""
    one, faces, _, _ = bar(vertices)
    size = diagonal(one)
    aside = np.array([0.0, size, 0.0])
    points, faces = np.vstack([one, one + aside]), np.vstack([faces, faces + len(one)])
    chosen = np.linspace(0, len(one) - 1, 12).astype(np.int32)
    anchors = np.concatenate([chosen, chosen + len(one)])
    deformer = meanvalue.Deformer(points, faces, anchors, strengths=np.ones(24))
    targets = np.repeat(points[anchors][None], 8, axis=0)
    targets[:, 12:, 2] += 0.3 * size
    targets[:, :4, 2] += 0.02 * size * np.arange(8)[:, None]
    weights = np.ones((8, 24))
    weights[4:, 12:] = 0.0
    shapes = deformer.solve_sequence(targets, weights=weights, overlap=0).vertices
    for frame in (3, 4, 7):
        alone = deformer.solve(targets[frame], weights=weights[frame], settle=True).vertices
        assert np.abs(shapes[frame] - alone).max() < 1e-3 * size, frame


def test_ramps_are_1_far_from_gaps_and_0_in_them():
    present = np.ones(60, bool)
    present[20:30] = present[34:40] = False
    ramp = sample_times.ramps(present, 6)
    assert np.array_equal(ramp == 0.0, ~present)
    assert (ramp[:14] == 1.0).all() and (ramp[46:] == 1.0).all() and (ramp[14:20] < 1.0).all()
    steps = ramp[14:20] / ramp[13:19]
    assert np.allclose(steps, steps[0]) and np.allclose(ramp[40:47], ramp[13:20][::-1])
    assert ramp[30:34].max() < 0.01, "a moment between two gaps counts little"
    assert (sample_times.ramps(np.ones(5, bool), 6) == 1.0).all()
    assert (sample_times.ramps(np.zeros(5, bool), 6) == 0.0).all()
    frames, keyed = sample_times.changing_keys(ramp, np.arange(60.0))
    assert np.allclose(np.interp(np.arange(60.0), frames, keyed), ramp) and len(frames) < 40
    assert len(sample_times.changing_keys(np.ones(5), np.arange(5.0))[0]) == 0


def test_skin_does_not_jump_where_an_anchor_fades_out_and_in(soft):
    """An anchor that the others would not have where it is: 10 % of the size away from its place."""
    points, _, chosen, _ = soft
    deformer, _ = bind(soft, 0.05)
    targets = np.repeat(points[chosen][None], 50, axis=0)
    targets[:, 5, 1] += 0.1 * diagonal(points)
    present = np.ones(50, bool)
    present[20:32] = False
    jump = {}
    for name, counts in (("at once", present.astype(float)), ("fading", sample_times.ramps(present, 8))):
        weights = np.ones(targets.shape[:2])
        weights[:, 5] = counts
        holed = np.where(weights[..., None] > 0.0, targets, np.nan)
        shapes = deformer.solve_sequence(holed, weights=weights).vertices.astype(float)
        jump[name] = np.linalg.norm(np.diff(shapes, 2, axis=0), axis=2).max() / diagonal(points)
        assert np.linalg.norm(shapes[25] - shapes[0], axis=1).max() > 0.05 * diagonal(points), "it is let go"
    assert jump["at once"] > 0.03
    assert jump["fading"] < 0.5 * jump["at once"], jump


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        ([1.0, 2.0], "weights has 2 numbers"),
        ([float("nan")] + 11 * [1.0], "from 0 to 1"),
        ([], "weights is empty"),
        ([[1.0]], "weights has the shape"),
    ],
)
def test_wrong_weights_are_named(soft, weights, words):
    deformer, _ = bind(soft)
    with pytest.raises(meanvalue.InvalidInput) as raised:
        deformer.solve(soft[3][0], weights=weights)
    assert words in str(raised.value)


def test_a_hard_anchor_can_not_be_freed():
    points, faces, anchors, pieces = bar(200)
    deformer = meanvalue.Deformer(points, faces, anchors, handles=pieces)
    with pytest.raises(meanvalue.InvalidInput, match="met exactly"):
        deformer.solve(points[anchors], weights=np.full(len(anchors), 0.5))


@pytest.mark.parametrize("wrong", [np.nan, -0.1, 1.1])
def test_wrong_weights_of_a_clip_are_named_with_their_frame(soft, wrong):
    deformer, _ = bind(soft)
    weights = np.ones(soft[3].shape[:2])
    weights[7, 3] = wrong
    with pytest.raises(meanvalue.InvalidInput, match=r"frame 7: weights\[3\]"):
        deformer.solve_sequence(soft[3], weights=weights)


def test_more_freed_anchors_than_columns_are_kept_of():
    """Those that lose most are corrected, so that the answer stays that of a bind without them."""
    points, faces, _, _ = bar(4000)
    chosen = np.linspace(0, len(points) - 1, 400).astype(np.int32)
    targets = points[chosen] + 0.1 * np.sin(points[chosen])
    weights = np.ones(len(chosen))
    weights[np.arange(400) % 4 != 0] = 0.0  # 300 of them
    freed = meanvalue.Deformer(points, faces, chosen, strengths=np.full(400, 1.0)).solve(targets, weights=weights)
    kept = chosen[weights > 0.0]
    expected = meanvalue.Deformer(points, faces, kept, strengths=np.full(len(kept), 1.0)).solve(targets[weights > 0.0])
    assert np.abs(freed.vertices - expected.vertices).max() < 0.01 * diagonal(points)
