# SPDX-License-Identifier: GPL-3.0-or-later
"""Rings of vertices around a limb: where a plane cuts the mesh."""

import numpy as np


class Ring:
    """Vertices around `centre`: numbers (k,), and angles (k,) about an axis.

    radius: how far they are from the centre on average; held: angles (h,) of what is held beside it.
    """

    def __init__(self, numbers, points, axis, held):
        self.centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
        self.numbers = numbers
        across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
        self._across = np.stack([across, np.cross(axis, across)], axis=1) / np.linalg.norm(across)
        self.radius = float(np.linalg.norm((points - self.centre) @ self._across, axis=1).mean())
        self.angles, self.held = self._angles(points), self._angles(held)

    @property
    def bare(self):
        """Radians of the widest stretch that nothing is held on."""
        held = np.sort(self.held)
        return float(np.diff(np.append(held, held[0] + 2.0 * np.pi)).max())

    def spread(self, count, taken):
        """At most `count` vertices, none of `taken`, as far round from each other and from what is held as can be."""
        free = np.array([number not in taken for number in self.numbers])
        numbers, angles, held = self.numbers[free], self.angles[free], list(self.held)
        chosen = []
        for _ in range(min(count, len(numbers))):
            gaps = np.min([_apart(angles, angle) for angle in held], axis=0) if held else np.ones(len(numbers))
            if not gaps.max() > 0.0:
                break
            best = int(gaps.argmax())
            chosen.append(int(numbers[best]))
            held.append(angles[best])
        return chosen

    def _angles(self, points):
        x, y = ((points - self.centre) @ self._across).T
        return np.arctan2(y, x)


def ring_around(middle, axis, vertices, triangles, held):
    """The `Ring` where the plane through `middle` (3,) across `axis` (3,) cuts the mesh: the nearest one, or None.

    vertices  (n, 3); triangles  (t, 3); held  (h, 3) points that are held beside the plane.
    """
    is_above = (vertices - middle) @ axis > 0.0
    cut = triangles[is_above[triangles].any(axis=1) & ~is_above[triangles].all(axis=1)]
    rings = [Ring(numbers, vertices[numbers], axis, held) for numbers in _joined(cut)]
    rings = [ring for ring in rings if ring.radius > 0.0]
    return min(rings, key=lambda ring: np.linalg.norm(ring.centre - middle), default=None)


def _joined(triangles):
    """[vertex numbers (k,)] of what hangs together in triangles (t, 3)."""
    numbers, corners = np.unique(triangles, return_inverse=True)
    corners = corners.reshape(-1, 3)
    label = np.arange(len(numbers))
    while True:
        least = label.copy()
        np.minimum.at(least, corners.ravel(), np.repeat(label[corners].min(axis=1), 3))
        least = least[least]  # of a label's own label: long rings take few rounds
        if np.array_equal(least, label):
            return [numbers[label == one] for one in np.unique(label)]
        label = least


def _apart(angles, angle):
    return np.abs((angles - angle + np.pi) % (2.0 * np.pi) - np.pi)
