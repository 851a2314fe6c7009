# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving every frame of a clip, and anchors that count less for a while."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from addon.scene.core import sample_times  # noqa: E402
from blender_tests.support import figure_body, rings, stress  # noqa: E402
from blender_tests.support.stress import held_bar  # noqa: E402
from native.benchmarks.rigid import rotation_about  # noqa: E402

FRAMES = 60
CHUNK = 16
OVERLAP = 4


def swing(points, anchors, pieces, frames=FRAMES):
    """(f, k, 3): the right end swings to and fro by 50 degrees."""
    right = points[anchors][pieces == 1]
    centre = points.mean(axis=0)
    targets = np.repeat(points[anchors][None], frames, axis=0)
    for frame in range(frames):
        turn = rotation_about((0, 0, 1), 50.0 * np.sin(0.12 * frame))
        targets[frame, pieces == 1] = centre + (right - centre) @ turn.T
    return targets


def diagonal(points):
    return float(np.linalg.norm(np.ptp(points, axis=0)))


@pytest.fixture(scope="module")
def clip():
    points, faces, anchors, pieces = held_bar(600)
    deformer = meanvalue.Deformer(points, faces, anchors, handles=pieces)
    targets = swing(points, anchors, pieces)
    whole = deformer.solve_sequence(targets, chunk=CHUNK, overlap=OVERLAP, threads=1)
    return points, anchors, deformer, targets, whole


def test_frames_are_at_their_minimum_though_an_arm_folds():
    """A figure's hand goes up and down; little energy is left to gain on a long way."""
    body = figure_body.body(spacing=0.025)
    points, faces = body.vertices, rings.triangles(body.quads)
    inward = points[:, 0].max() - points[:, 0]
    anchors = np.flatnonzero((inward < 0.09) | ((inward > 0.53) & (inward < 0.62))).astype(np.int32)
    is_hand = inward[anchors] < 0.09
    deformer = meanvalue.Deformer(points, faces, anchors, handles=is_hand.astype(np.int32), roi=inward < 0.62)
    ways = [np.interp(np.arange(24), [0, 11, 23], way) for way in ([0, -0.25, -0.35], [0, 0, 0], [0, 0.6, -0.6])]
    targets = points[anchors] + np.transpose(ways)[:, None] * is_hand[:, None]
    for frame, shape in enumerate(deformer.solve_sequence(targets, overlap=0).vertices):
        least = deformer.solve(targets[frame], start=shape.astype(float), tolerance=1e-7, max_iterations=9000).vertices
        assert np.linalg.norm(shape - least, axis=1).max() < 2e-4 * diagonal(points), frame


def test_every_frame_is_solved_and_meets_its_anchors(clip):
    points, anchors, _, targets, whole = clip
    assert whole.first == 0
    assert whole.vertices.shape == (FRAMES, len(points), 3)
    assert whole.vertices.dtype == np.float32
    assert whole.converged.dtype == bool
    assert whole.converged.all()
    assert whole.errors == ()
    assert whole.iterations.dtype == np.int32
    assert np.isfinite(whole.energies).all()
    np.testing.assert_array_equal(whole.vertices[:, anchors], targets.astype(np.float32))


def test_each_frame_is_what_a_solve_from_rest_settles_at(clip):
    points, _, deformer, targets, whole = clip
    for frame in (0, 7, CHUNK - 1, CHUNK, 37, FRAMES - 1):
        alone = deformer.solve(targets[frame], settle=True)
        assert np.abs(whole.vertices[frame] - alone.vertices).max() < 1e-6 * diagonal(points)
        assert whole.energies[frame] == alone.energy


PARTS = [(0, 1), (5, 9), (CHUNK - 2, CHUNK + 3), (CHUNK, 2 * CHUNK), (13, 14), (47, FRAMES)]


@pytest.mark.parametrize(
    "threads, frames", [*((threads, (0, FRAMES)) for threads in (2, 3, 7)), *((0, p) for p in PARTS)]
)
def test_threads_do_not_change_a_bit_and_a_part_of_the_clip_has_the_bits_of_the_whole(clip, threads, frames):
    _, _, deformer, targets, whole = clip
    part = deformer.solve_sequence(targets, chunk=CHUNK, overlap=OVERLAP, threads=threads, frames=frames)
    assert part.first == frames[0]
    for name in ("vertices", "energies", "iterations"):
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[slice(*frames)])


def test_frames_are_handed_over_in_order_and_not_kept(clip):
    _, _, deformer, targets, whole = clip
    got = []
    result = deformer.solve_sequence(
        targets,
        chunk=CHUNK,
        overlap=OVERLAP,
        threads=1,
        on_frame=lambda frame, shape: got.append((frame, shape.copy())),
    )
    assert [frame for frame, _ in got] == list(range(FRAMES))
    np.testing.assert_array_equal([shape for _, shape in got], whole.vertices)
    assert len(result.vertices) == 0
    np.testing.assert_array_equal(result.energies, whole.energies)


@pytest.mark.parametrize("chunk", [FRAMES, 10**9, 2**31 - 1])
def test_one_run_for_all_frames(clip, chunk):
    _, _, deformer, targets, _ = clip
    got = []
    deformer.solve_sequence(targets, chunk=chunk, threads=2, on_frame=lambda _, shape: got.append(shape.copy()))
    np.testing.assert_array_equal(got, deformer.solve_sequence(targets, chunk=chunk).vertices)


def test_a_callback_may_cancel_or_raise(clip):
    _, _, deformer, targets, _ = clip
    execution = meanvalue.Execution()
    with pytest.raises(KeyError):
        deformer.solve_sequence(targets, on_frame=lambda *_: {}["a name"])
    with pytest.raises(meanvalue.Cancelled):
        deformer.solve_sequence(targets, execution=execution, on_frame=lambda *_: execution.cancel())


def roughest(paths):
    """The largest second difference of any of f x n x 3."""
    return np.linalg.norm(np.diff(np.asarray(paths, np.float64), 2, axis=0), axis=2).max()


@pytest.fixture(scope="module")
def buckled():
    """(deformer, anchors, targets): a bar squeezed by a fifth, its ends turned until it snaps to the other side."""
    points, faces = stress.bar(600)
    points = np.asarray(points, np.float64)
    length = np.ptp(points[:, 2])
    is_low, is_high = points[:, 2] < 0.08 * length, points[:, 2] > 0.92 * length
    anchors = np.flatnonzero(is_low | is_high).astype(np.int32)
    pieces = is_high[anchors].astype(np.int32)
    targets = np.repeat(points[anchors][None], FRAMES, axis=0)
    for frame in range(FRAMES):
        for piece, sign in ((0, 1.0), (1, -1.0)):
            turn = rotation_about((0, 1, 0), sign * 40.0 * np.cos(np.pi * frame / (FRAMES - 1)))
            end = points[anchors][pieces == piece]
            centre = end.mean(axis=0)
            targets[frame, pieces == piece] = centre + (end - centre) @ turn.T + [0.0, 0.0, 0.1 * sign * length]
    return meanvalue.Deformer(points, faces, anchors, handles=pieces), anchors, targets


@pytest.mark.parametrize("chunk", [FRAMES, 24])
def test_a_snap_through_is_spread_over_frames(buckled, chunk):
    """A minimum ceases to be: all of the bar jumps between two frames, whichever the solver is."""
    deformer, anchors, targets = buckled
    jump = roughest(deformer.solve_sequence(targets, chunk=FRAMES, overlap=0).vertices)
    assert jump > 100 * roughest(targets)
    spread = deformer.solve_sequence(targets, chunk=chunk, overlap=8)
    assert roughest(spread.vertices) < 0.05 * jump
    np.testing.assert_array_equal(spread.vertices[:, anchors], targets.astype(np.float32))


def test_a_snap_goes_the_surfaces_own_way_over_a_few_frames_and_is_told(buckled):
    """Each frame is near its own minimum; those where nothing snaps, and keys, are what was solved."""
    deformer, _, targets = buckled
    raw = deformer.solve_sequence(targets, chunk=FRAMES, overlap=0)
    steps = np.linalg.norm(np.diff(raw.vertices, axis=0), axis=2).max(axis=1)
    snap = int(steps.argmax()) + 1
    assert raw.snaps == (snap,)
    size = np.linalg.norm(np.ptp(raw.vertices[0], axis=0))
    begin = snap - 8  # some vertices and frames are enough
    few = raw.vertices[begin : snap + 9, ::3], targets[begin : snap + 9]
    assert meanvalue.find_snaps(*few, size) == (8,)
    assert meanvalue.find_snaps(*few, 100.0 * size) == ()
    for kept in ([], [snap - 2, snap + 1]):
        spread = deformer.solve_sequence(targets, chunk=FRAMES, kept=kept)
        assert spread.snaps == (snap,)
        is_moved = (spread.vertices != raw.vertices).any(axis=(1, 2))
        assert is_moved[snap - 1] and is_moved[snap] and not is_moved[kept].any()
        assert not is_moved[: snap - 15].any() and not is_moved[snap + 15 :].any()
        for frame in np.flatnonzero(is_moved):
            shape = spread.vertices[frame].astype(float)
            energy = deformer.solve(targets[frame], start=shape, max_iterations=0).energy
            assert energy < 1.05 * raw.energies[frame], frame
        part = deformer.solve_sequence(targets, chunk=FRAMES, kept=kept, frames=(snap - 1, snap + 2), threads=1)
        np.testing.assert_array_equal(part.vertices, spread.vertices[snap - 1 : snap + 2])


@pytest.mark.parametrize(
    "shape, size, said",
    [((20, 4, 2), 1.0, "shapes"), ((19, 4, 3), 1.0, "shapes"), ((20, 4, 3), 0.0, "size"), ((20, 4, 3), np.nan, "size")],
)
def test_snaps_are_asked_for_with_frames_of_both(shape, size, said):
    with pytest.raises(meanvalue.InvalidInput, match=said):
        meanvalue.find_snaps(np.zeros(shape), np.zeros((20, 1, 3)), size)
    with pytest.raises(meanvalue.InvalidInput, match="not finite"):
        meanvalue.find_snaps(np.zeros((20, 4, 3)), np.full((20, 1, 3), np.nan), 1.0)
    assert meanvalue.find_snaps(np.zeros((0, 4, 3)), np.zeros((0, 1, 3)), 1.0) == ()


def test_the_first_frame_is_as_good_as_the_next(buckled):
    """A solve from rest stops before its minimum, and the next frame would be nearer to it."""
    deformer, _, targets = buckled
    still = np.repeat(targets[5:6], 3, axis=0)
    alone = deformer.solve(still[0]).vertices
    nearer = deformer.solve(still[0], start=alone).vertices
    shapes = deformer.solve_sequence(still, overlap=0).vertices
    assert np.abs(shapes[1] - shapes[0]).max() < 0.5 * np.abs(nearer - alone).max()


def test_progress_counts_once_over_all_frames(clip):
    _, _, deformer, targets, _ = clip
    execution = meanvalue.Execution()
    told = []
    deformer.solve_sequence(
        targets, chunk=4, overlap=2, threads=1, execution=execution, on_frame=lambda *_: told.append(execution.progress)
    )
    assert told == sorted(told)
    assert told[0] < 0.2
    assert told[-1] == pytest.approx(1.0)


def test_smooth_targets_give_a_smooth_sequence_across_runs(clip):
    """The largest second difference of any vertex, over that of the targets: also where one run fades into the next."""
    _, _, _, targets, whole = clip
    assert roughest(whole.vertices) < 1.5 * roughest(targets)


def test_a_frame_that_fails_is_told_and_does_not_end_the_rest(clip):
    _, _, deformer, targets, whole = clip
    broken = targets.copy()
    broken[20, 3, 1] = np.nan
    result = deformer.solve_sequence(broken, chunk=CHUNK, overlap=OVERLAP)
    assert [frame for frame, _ in result.errors] == [20]
    assert "targets" in result.errors[0][1]
    assert np.isnan(result.energies[20])
    assert not result.converged[20]
    np.testing.assert_array_equal(result.vertices[20], result.vertices[19])
    np.testing.assert_array_equal(result.vertices[: CHUNK - OVERLAP], whole.vertices[: CHUNK - OVERLAP])
    assert np.isfinite(result.vertices).all()


@pytest.mark.parametrize("begin", [CHUNK - OVERLAP - 3, CHUNK - 2, CHUNK])
def test_a_dropout_across_two_runs_holds_the_last_shape(clip, begin):
    points, _, deformer, targets, _ = clip
    end = CHUNK + 5
    broken = targets.copy()
    broken[begin:end] = np.nan
    result = deformer.solve_sequence(broken, chunk=CHUNK, overlap=OVERLAP)
    assert [frame for frame, _ in result.errors] == list(range(begin, end))
    held = result.vertices[begin - 1]
    for frame in range(begin, end):
        assert np.abs(result.vertices[frame] - held).max() < 3e-3 * diagonal(points)
    part = deformer.solve_sequence(broken, chunk=CHUNK, overlap=OVERLAP, frames=(CHUNK + 1, CHUNK + 9))
    np.testing.assert_array_equal(part.vertices, result.vertices[CHUNK + 1 : CHUNK + 9])


def test_a_first_frame_that_fails_holds_the_rest_shape(clip):
    points, _, deformer, targets, _ = clip
    broken = targets.copy()
    broken[0] = np.inf
    result = deformer.solve_sequence(broken, chunk=CHUNK, overlap=OVERLAP)
    np.testing.assert_array_equal(result.vertices[0], points.astype(np.float32))
    assert [frame for frame, _ in result.errors] == [0]


def test_a_clip_without_frames_is_none(clip):
    _, anchors, deformer, _, _ = clip
    result = deformer.solve_sequence(np.empty((0, len(anchors), 3)))
    assert len(result.vertices) == 0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"chunk": 0}, "chunk is 0"),
        ({"overlap": -1}, "overlap is -1"),
        ({"frames": (3, 2)}, "60 frames"),
        ({"frames": (0, FRAMES + 1)}, "60 frames"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"kept": [4, 2]}, "kept"),
        ({"max_iterations": -1}, "max_iterations"),
        ({"threads": -1}, "threads"),
        ({"weights": np.ones((2, 2))}, "weights has the shape (2, 2)"),
    ],
)
def test_wrong_arguments_are_named(clip, arguments, words):
    _, _, deformer, targets, _ = clip
    with pytest.raises(meanvalue.InvalidInput) as raised:
        deformer.solve_sequence(targets, **arguments)
    assert words in str(raised.value)


def test_targets_of_another_form_are_named(clip):
    _, _, deformer, targets, _ = clip
    for wrong in (targets[0], targets[:, :-1], targets[:, :, :2], targets.astype(complex)):
        with pytest.raises(meanvalue.InvalidInput, match="targets"):
            deformer.solve_sequence(wrong)


def test_what_single_precision_cannot_hold_is_refused_or_told():
    points, faces, anchors, pieces = held_bar(200)
    targets = np.repeat(points[anchors][None], 4, axis=0)
    huge = meanvalue.Deformer(1e39 * points, faces, anchors, handles=pieces)
    with pytest.raises(meanvalue.InvalidInput, match=r"rest shape has coordinates up to .* single precision"):
        huge.solve_sequence(1e39 * targets)
    large = meanvalue.Deformer(1e33 * points, faces, anchors, handles=pieces)
    targets[2, pieces == 1] += 1e5 * diagonal(points)
    result = large.solve_sequence(1e33 * targets)
    assert [frame for frame, _ in result.errors] == [2] and "single precision" in result.errors[0][1]
    assert np.isfinite(result.vertices).all()
    np.testing.assert_array_equal(result.vertices[2], result.vertices[1])


# -- anchors that count less for a while, in single solves and along a clip --------------------------------------------


@pytest.fixture(scope="module")
def soft():
    """A bar by twelve soft single vertices, and its targets swung."""
    points, faces, anchors, pieces = held_bar(2600)
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
    one, faces, _, _ = held_bar(vertices)
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
    points, faces, anchors, pieces = held_bar(200)
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
    points, faces, _, _ = held_bar(4000)
    chosen = np.linspace(0, len(points) - 1, 400).astype(np.int32)
    targets = points[chosen] + 0.1 * np.sin(points[chosen])
    weights = np.ones(len(chosen))
    weights[np.arange(400) % 4 != 0] = 0.0  # 300 of them
    freed = meanvalue.Deformer(points, faces, chosen, strengths=np.full(400, 1.0)).solve(targets, weights=weights)
    kept = chosen[weights > 0.0]
    expected = meanvalue.Deformer(points, faces, kept, strengths=np.full(len(kept), 1.0)).solve(targets[weights > 0.0])
    assert np.abs(freed.vertices - expected.vertices).max() < 0.01 * diagonal(points)
