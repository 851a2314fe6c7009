# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes between shapes: what must hold of them whatever the shapes are, and shapes of which the truth is known."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.bent_tubes import bent, diagonal, fitted, posed, rms, tube, twisted  # noqa: E402
from native.benchmarks import rigid  # noqa: E402

UP = np.array([0.0, 0.0, 1.0])


def largest_move(shape, other):
    return np.linalg.norm(shape - other, axis=1).max() / diagonal(other)


@pytest.fixture(scope="module")
def bend():
    vertices, faces = tube()
    shapes = [vertices, bent(vertices, 150)]
    return vertices, faces, shapes, meanvalue.Morpher(shapes, faces)


@pytest.fixture(scope="module")
def three():
    """Three shapes that turn about several axes, one of them thicker."""
    vertices, faces = tube(radius=0.6)
    shapes = [
        vertices,
        posed(vertices, [(3, (1, 0, 0), 80), (7, (0, 1, 0), 60)]),
        1.4 * twisted(vertices * [1.2, 1.2, 1], 90) @ rigid.rotation_about([1, 2, 0], 70).T + [5, 0, 2],
    ]
    return faces, shapes, meanvalue.Morpher(shapes, faces)


@pytest.mark.parametrize(("deform", "angle"), [(bent, 330), (twisted, 330)])
def test_turns_beyond_half_a_turn_are_followed(deform, angle):
    vertices, faces = tube()
    shapes = [vertices, deform(vertices, angle)]
    half = meanvalue.Morpher(shapes, faces).solve([0.5, 0.5]).vertices
    truth = deform(vertices, 0.5 * angle)
    assert rms(half, truth) < 0.12 * rms(0.5 * (shapes[0] + shapes[1]), truth)


def second_differences(morpher, steps):
    """The largest of all vertices, while a slider goes from one shape to the other in `steps`."""
    shapes = np.array([morpher.solve([1 - share, share]).vertices for share in np.linspace(0, 1, steps + 1)])
    return np.linalg.norm(shapes[2:] - 2 * shapes[1:-1] + shapes[:-2], axis=2).max()


@pytest.mark.slow
@pytest.mark.parametrize("angle", [150, 360])
@pytest.mark.parametrize("joints", [range(8), range(8, 20)], ids=["all", "tip"])
def test_paths_are_smooth_however_far_a_tentacle_curls(joints, angle):
    """Second differences fall with the square of the step; at a kink they would be halved, at a jump stay."""
    vertices, faces = tube(radius=0.5)
    heights = np.linspace(1.0 if joints[0] == 0 else 4.0, 9.5, len(joints))
    end = posed(vertices, [(height, (1, 0, 0), angle / len(joints)) for height in heights], width=1.0)
    morpher = meanvalue.Morpher([vertices, end], faces)
    coarse, fine = (second_differences(morpher, steps) for steps in (32, 64))
    assert fine < 0.4 * coarse
    back = meanvalue.Morpher([end, vertices], faces)
    for share in (0.27, 0.5, 0.73):
        there = morpher.solve([1 - share, share]).vertices
        assert largest_move(back.solve([share, 1 - share]).vertices, there) < 1e-6
    assert largest_move(morpher.solve([0, 1]).vertices, end) < 1e-6
    assert largest_move(morpher.solve([1, 0]).vertices, vertices) < 1e-6


def test_what_does_not_move_stays_where_an_arm_bends():
    vertices, faces = tube(radius=0.5)
    shapes = [vertices, posed(vertices, [(7, (1, 0, 0), 120)])]
    half = meanvalue.Morpher(shapes, faces).solve([0.5, 0.5]).vertices
    still = vertices[:, 2] < 4.0
    assert np.array_equal(*(shape[still] for shape in shapes))
    assert largest_move(half[still], vertices[still]) < 0.005
    assert largest_move(half[~still], vertices[~still]) > 0.2


LIMBS = {
    "elbow": [(5, (1, 0, 0), 140)],
    "two joints": [(3, (1, 0, 0), 70), (7, (1, 0, 0), 70)],
    "several axes": [(2.5, (1, 0, 0), 100), (5, (0, 1, 0), 100), (7.5, (1, 1, 0), 80)],
    "twist": [(2 + k, (0, 0, 1), 160 / 6) for k in range(6)],
}


@pytest.mark.parametrize("joints", LIMBS.values(), ids=LIMBS)
@pytest.mark.parametrize("share", [0.25, 0.5])
def test_a_limb_bends_as_its_armature_does(joints, share):
    vertices, faces = tube(radius=0.6)
    shapes = [vertices, posed(vertices, joints)]
    truth = posed(vertices, [(height, axis, share * angle) for height, axis, angle in joints])
    between = meanvalue.Morpher(shapes, faces).solve([1 - share, share]).vertices
    linear = (1 - share) * shapes[0] + share * shapes[1]
    assert rms(between, truth) < 0.25 * rms(linear, truth)


def test_the_ends_come_back(three):
    _, shapes, morpher = three
    for number, shape in enumerate(shapes):
        weights = np.eye(3)[number]
        assert largest_move(morpher.solve(weights).vertices, shape) < 1e-6
        assert largest_move(morpher.solve(0.1 * weights).vertices, shape) < 1e-6, "weights are divided by their sum"


@pytest.mark.slow
def test_the_order_of_three_shapes_does_not_matter_where_they_turn_far():
    vertices, faces = tube(1900, radius=0.6)
    axes = ([1, 0, 0], [0, 1, 0], [1, 1, 0])
    shapes = [
        bent(vertices, angle) @ rigid.rotation_about(axis, turn).T
        for angle, axis, turn in zip((170, 230, 290), axes, (0, 70, 140), strict=True)
    ]
    weights = np.array([0.5, 0.2, 0.3])
    expected = meanvalue.Morpher(shapes, faces).solve(weights).vertices
    for order in ([1, 2, 0], [2, 1, 0], [0, 2, 1]):
        other = meanvalue.Morpher([shapes[k] for k in order], faces)
        assert largest_move(other.solve(weights[order]).vertices, expected) < 1e-6


@pytest.mark.parametrize("angle", [60, 120, 180])
def test_similar_shapes_move_rigidly_and_grow_geometrically(angle):
    vertices, faces = tube()
    moved = 4.0 * vertices @ rigid.rotation_about([0.3, 1, 0.2], angle).T + [3, -20, 5]
    half = meanvalue.Morpher([vertices, moved], faces).solve([0.5, 0.5]).vertices
    assert np.allclose(half.mean(axis=0), 0.5 * (vertices + moved).mean(axis=0), atol=1e-6 * diagonal(moved))
    assert rms(half / 2.0, vertices) < 1e-6
    rotation = rigid.nearest_rotations(((half - half.mean(axis=0)).T @ (vertices - vertices.mean(axis=0)))[None])[0]
    if angle < 180:  # by the best fit to the mean of all positions, which is half of the turn for a ball alone
        assert np.degrees(np.arccos(0.5 * (np.trace(rotation) - 1))) == pytest.approx(0.5 * angle, rel=0.05)


def test_results_depend_on_the_weights_alone(three):
    faces, shapes, morpher = three
    first = morpher.solve([0.3, 0.3, 0.4]).vertices.copy()
    morpher.solve([1.5, -0.5, 0.0])
    assert np.array_equal(morpher.solve([0.3, 0.3, 0.4]).vertices, first)
    alone = meanvalue.Morpher(shapes, faces, threads=1).solve([0.3, 0.3, 0.4]).vertices
    assert np.array_equal(alone, first), "for any number of threads"


def test_beside_the_interpreter(three):
    faces, shapes, morpher = three
    expected = morpher.solve([0.3, 0.3, 0.4]).vertices
    bound = meanvalue.start_bind_morph(shapes, faces).result()
    assert np.array_equal(bound.start_solve([0.3, 0.3, 0.4]).result().vertices, expected)
    execution = meanvalue.Execution()
    execution.cancel()
    with pytest.raises(meanvalue.Cancelled):
        morpher.solve([0.3, 0.3, 0.4], execution=execution)
    assert np.array_equal(morpher.solve([0.3, 0.3, 0.4]).vertices, expected)


def test_a_part_is_placed_by_its_anchors(bend):
    vertices, faces, shapes, free = bend
    anchors = np.flatnonzero(vertices[:, 2] < 0.5).astype(np.int32)
    held = meanvalue.Morpher(shapes, faces, anchors)
    for number, weights in enumerate(np.eye(2)):
        assert largest_move(held.solve(weights).vertices, shapes[number]) < 1e-6
    half, whole = held.solve([0.5, 0.5]).vertices, free.solve([0.5, 0.5]).vertices
    assert rms(half, whole) < 1e-3
    # Placed by them: they are the same in both shapes, but for the bend between.
    moved = np.linalg.norm(half[anchors] - 0.5 * (shapes[0] + shapes[1])[anchors], axis=1)
    assert moved.max() < 0.01 * diagonal(vertices)


def test_parts_of_a_mesh_are_all_placed():
    vertices, faces = tube(400)
    both = np.concatenate([vertices, 0.3 * vertices + [4, 0, 0], [[9, 9, 9]]])
    faces = np.concatenate([faces, faces + len(vertices)])
    upwards = np.array([0.0, 1.0, 0.0])
    moved = both + 2 * upwards
    half = meanvalue.Morpher([both, moved], faces).solve([0.5, 0.5]).vertices
    assert largest_move(half, both + upwards) < 1e-6


def test_a_mesh_without_any_ring():
    line = np.arange(12.0)[:, None] * [1, 2, 3] + [[0, 0, 0]]
    for vertices, faces in (
        (np.eye(3), np.array([[0, 1, 2]])),
        (np.eye(3), np.empty((0, 3), int)),
        (line, np.array([[k, k + 1, k + 2] for k in range(10)])),
    ):
        morpher = meanvalue.Morpher([vertices, vertices + UP], faces)
        assert np.isfinite(morpher.solve([0.5, 0.5]).vertices).all()


ERRORS = {
    "counts": (lambda a, f: ([a, a[:-1]], f), r"shapes\[1\] has \d+ rows, but there are \d+ vertices of shapes\[0\]"),
    "faces": (lambda a, f: ([a, a], [f, f[::-1]]), r"triangle 0 is .* in faces\[1\], but .* in faces\[0\]"),
    "face counts": (lambda a, f: ([a, a], [f, f[1:]]), r"faces\[1\] has \d+ triangles, but faces\[0\] has \d+"),
    "one shape": (lambda a, f: ([a], f), "two or more"),
    "not a number": (lambda a, f: ([a, np.where(a > 1e9, a, np.nan)], f), r"shapes\[1\]"),
    "mirrored": (lambda a, f: ([a, a * [-1, 1, 1]], f), r"shapes\[1\] is mirrored.*volume is -\d"),
    "a point": (lambda a, f: ([a, 0 * a], f), r"shapes\[1\].*one place"),
}


@pytest.mark.parametrize(("make", "words"), ERRORS.values(), ids=ERRORS)
def test_shapes_that_do_not_fit_are_refused(make, words):
    shapes, faces = make(*tube(400))
    with pytest.raises(meanvalue.InvalidInput, match=words):
        meanvalue.Morpher(shapes, faces)


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        ([np.nan, 1, 0], "weight of shape 0 is nan"),
        ([0, 0, 0], "all 3 weights are 0"),
        ([1, -1, 0], "cancel"),
        ([1, 0], r"shape \(2,\); give \(3,\)"),
        (np.ones((3, 5)), r"shape \(3, 5\); give \(3,\), .* or \(3, \d+\)"),
    ],
)
def test_weights_that_say_nothing_are_refused(three, weights, words):
    _, _, morpher = three
    with pytest.raises(meanvalue.InvalidInput, match=words):
        morpher.solve(weights)
    assert morpher.solve([1, 0, 0]).converged


def test_what_has_no_finite_shape_is_refused():
    vertices, faces = tube(400)
    shapes = vertices, 1000.0 * vertices
    with pytest.raises(meanvalue.InvalidInput, match="far outside 0 to 1"):
        meanvalue.Morpher(shapes, faces).solve([-490.0, 491.0])
    with pytest.raises(meanvalue.InvalidInput, match="None"):
        meanvalue.blend([meanvalue.encode(vertices, faces), None], [0.5, 0.5])
    with pytest.raises(meanvalue.InvalidInput, match="far outside 0 to 1"):
        pytest.importorskip("meanvalue.baselines").poisson_morph(*shapes, faces, 1e308)


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ([3], "parts has 3, but there are 3 shapes"),
        ([-1], "parts has -1"),
        ([0, 1, 2], "all 3 shapes are parts"),
        ([0.5], "parts"),
    ],
)
def test_parts_that_are_none_are_refused(three, parts, words):
    _, shapes, morpher = three
    weights = np.repeat([[0.2], [0.3], [0.5]], len(shapes[0]), axis=1)
    with pytest.raises(meanvalue.InvalidInput, match=words):
        morpher.solve(weights, parts=parts)
    with pytest.raises(meanvalue.InvalidInput, match=words):
        morpher.solve([1, 0, 0], parts=parts)


def test_a_part_is_put_on_the_mix_of_the_others(three):
    """Alike everywhere, the weights are those of a mix without parts; and whichever has most, nothing jumps."""
    _, shapes, morpher = three
    height = shapes[0][:, 2]
    tip = np.clip(height - 7.0, 0.0, 1.0)

    def mixed(share, amount):
        weights = np.stack([1 - share - amount * tip, amount * tip, np.full(len(tip), share)])
        return morpher.solve(weights, parts=[1]).vertices

    for share in (0.3, 0.7):
        near = largest_move(mixed(share, 1e-6), morpher.solve([1 - share, 0, share]).vertices)
        assert near < 1e-4
    path = np.array([mixed(share, 0.8) for share in np.linspace(0, 1, 41)])
    steps = np.linalg.norm(np.diff(path, axis=0), axis=2).max(axis=1)
    assert np.linalg.norm(np.diff(path, 2, axis=0), axis=2).max() < 0.25 * steps.max()


@pytest.mark.parametrize("least", [0.5, 0.9, 0.95, 0.99, 0.9999, 1.0])
def test_a_named_part_that_is_everywhere_does_not_blow_up_what_it_is_put_on(least):
    side = np.linspace(-1.0, 1.0, 20)
    x, y = (each.ravel() for each in np.meshgrid(side, side))
    rest = np.stack([x, y, 0.1 * np.sin(3.0 * x)], axis=1)
    corner = (np.arange(19)[:, None] * 20 + np.arange(19)).ravel()
    faces = np.concatenate([
        np.stack([corner, corner + 1, corner + 21], axis=1), np.stack([corner, corner + 21, corner + 20], axis=1)
    ]).astype(np.int32)  # fmt: skip
    other = 1.3 * np.stack([np.sin(x), y, 1.0 - np.cos(x)], axis=1)
    masked = rest + np.stack([0.0 * x, 0.0 * x, 0.3 * y**2], axis=1)
    morpher = meanvalue.Morpher(np.stack([rest, other, masked]), faces)
    mask = least + (1.0 - least) * (x + 1.0) / 2.0

    def size(first, second):
        weights = np.stack([1.0 - first - second * mask, np.full_like(mask, first), second * mask], axis=0)
        return np.linalg.norm(np.ptp(morpher.solve(weights, parts=[2]).vertices, axis=0))

    sizes = [size(1.0, second) for second in (0.9, 0.95, 1.0)]
    assert 0.5 * size(1.0, 0.0) < min(sizes) and max(sizes) < 2.0 * size(1.0, 0.0)
    assert np.abs(np.diff(sizes)).max() < 0.1 * sizes[0]


# -- small parts that are not joined to the rest (eyes, buttons) go along with what they lie on ------------------------


TUBE, TUBE_FACES = tube(2000, radius=0.6)
HEIGHTS = (2.0, 5.0, 7.0, 9.0)
RADIUS = 0.15

MOTIONS = {
    "bend": lambda share: lambda points: bent(points, 150 * share),
    "twist": lambda share: lambda points: twisted(points, 160 * share),
    "head": lambda share: lambda points: posed(points, [(5, (0, 0, 1), 60 * share)]),
    "elbow": lambda share: lambda points: posed(points, [(5, (1, 0, 0), 60 * share)]),
}


def octahedron():
    points = np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], np.float64)
    corners = [(a, b, c) for a in (0, 1) for b in (2, 3) for c in (4, 5)]
    return points, np.array([(a, c, b) if (a + b + c) % 2 else (a, b, c) for a, b, c in corners])


def frame_of(deform, point, step=1e-4):
    """(3,), (3, 3): where a point goes, and how what is at it turns."""
    points = deform(np.concatenate([[point], point + step * np.eye(3)]))
    return points[0], rigid.nearest_rotations(((points[1:] - points[0]).T / step)[None])[0]


def with_buttons(deform):
    """A tube with rigid parts that float over it."""
    shapes = [deform(TUBE)]
    for height in HEIGHTS:
        place, turn = frame_of(deform, np.array([0.85, 0.0, height]))
        shapes.append(place + RADIUS * octahedron()[0] @ turn.T)
    return np.concatenate(shapes)


def all_faces():
    faces = [TUBE_FACES]
    for number in range(len(HEIGHTS)):
        faces.append(octahedron()[1] + len(TUBE) + 6 * number)
    return np.concatenate(faces)


def button_rows():
    return [slice(len(TUBE) + 6 * number, len(TUBE) + 6 * number + 6) for number in range(len(HEIGHTS))]


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("share", [0.25, 0.5])
def test_parts_stay_on_what_they_lie_on(motion, share):
    shapes = [with_buttons(motion(end)) for end in (0, 1)]
    truth = with_buttons(motion(share))
    morpher = meanvalue.Morpher(shapes, all_faces())
    assert morpher.report.component_count == 1 + len(HEIGHTS)
    between = morpher.solve([1 - share, share]).vertices
    centres = [shape[: len(TUBE)].mean(axis=0) for shape in (truth, between)]
    moment = (truth - centres[0])[: len(TUBE)].T @ (between - centres[1])[: len(TUBE)]
    placed = (between - centres[1]) @ rigid.nearest_rotations(moment[None])[0].T + centres[0]
    for rows in button_rows():
        assert np.linalg.norm((placed - truth)[rows].mean(axis=0)) < 0.25 * RADIUS
        assert rms(between[rows], shapes[0][rows]) < 1e-3, "rigid"
        assert np.linalg.norm((placed - truth)[rows], axis=1).max() < 0.5 * RADIUS
    for weights, end in zip(np.eye(2), shapes, strict=True):
        missed = np.linalg.norm(morpher.solve(weights).vertices - end, axis=1).max()
        assert missed < 1e-6 * diagonal(end)


def test_a_part_that_grows_with_the_surface_keeps_its_place():
    shapes = [with_buttons(MOTIONS["bend"](0)), 2.0 * with_buttons(MOTIONS["bend"](1))]
    half = meanvalue.Morpher(shapes, all_faces()).solve([0.5, 0.5]).vertices
    truth = np.sqrt(2.0) * with_buttons(MOTIONS["bend"](0.5))
    assert np.abs(fitted(half, truth) - truth).max() < 0.25 * RADIUS


@pytest.mark.parametrize("left", [0.0, 1e-3])
def test_what_one_shape_hides_does_not_make_the_rest_grow(left):
    centre = TUBE.mean(axis=0)
    hidden = centre + left * (TUBE - centre)
    faces = np.concatenate([TUBE_FACES, TUBE_FACES + len(TUBE)])
    shapes = [np.concatenate([TUBE, part + np.array([5, 0, 0])]) for part in (TUBE, hidden)]
    half = meanvalue.Morpher(shapes, faces).solve([0.5, 0.5]).vertices
    assert np.allclose(half[: len(TUBE)], TUBE, atol=1e-6 * diagonal(TUBE))


def test_a_part_that_moves_otherwise_goes_its_own_way():
    """One that stands beside the tube in both shapes is not swung around by it."""
    beside = 0.2 * octahedron()[0] + [0.0, 3.0, 8.0]
    shapes = [np.concatenate([deform(TUBE), beside]) for deform in (MOTIONS["elbow"](0), MOTIONS["elbow"](1))]
    faces = np.concatenate([TUBE_FACES, octahedron()[1] + len(TUBE)])
    half = meanvalue.Morpher(shapes, faces).solve([0.5, 0.5]).vertices
    still = shapes[0][: len(TUBE), 2] < 2.5
    shift = (half[: len(TUBE)] - shapes[0][: len(TUBE)])[still].mean(axis=0)
    assert np.abs(half[len(TUBE) :] - beside - shift).max() < 0.02 * diagonal(shapes[0])


def test_a_graft_takes_parts_along():
    """The upper half of a bent tube on a straight one, with what lies on it."""
    shapes = [with_buttons(MOTIONS["bend"](share)) for share in (0, 0.6)]
    share = np.clip((shapes[0][:, 2] - 4.0) / 0.5, 0.0, 1.0)
    graft = meanvalue.Morpher(shapes, all_faces()).solve([1 - share, share]).vertices
    for rows, height in zip(button_rows(), HEIGHTS, strict=True):
        near = np.abs(TUBE[:, 2] - height) < 0.6
        own = shapes[1] if height > 4.5 else shapes[0]
        distances = [np.linalg.norm(shape[rows].mean(0) - shape[: len(TUBE)][near], axis=1) for shape in (graft, own)]
        assert np.abs(distances[0] - distances[1]).max() < 0.5 * RADIUS, height
