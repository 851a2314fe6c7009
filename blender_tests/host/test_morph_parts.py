# SPDX-License-Identifier: GPL-3.0-or-later
"""Small parts that are not joined to the rest (eyes, buttons) go along with what they lie on, shape by shape."""

import numpy as np
import pytest

meanvalue = pytest.importorskip("meanvalue", reason="the native module is not on PYTHONPATH")

from blender_tests.support.bent_tubes import bent, diagonal, fitted, posed, rms, tube, twisted  # noqa: E402
from native.benchmarks import rigid  # noqa: E402

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
