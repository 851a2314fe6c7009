# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures on mixed shapes."""

import numpy as np


def rows(subject, straight, turned):
    """[(label, text)] for the report."""
    ends = edges(subject.polygons)
    triangles = np.concatenate([subject.polygons[:, [0, 1, 2]], subject.polygons[:, [0, 2, 3]]])
    found = []
    for name, shapes in (("straight lines", straight), ("rotation-aware", turned)):
        ratios = np.array([edge_ratios(shape, value, subject, ends) for shape, value in between(subject, shapes)])
        volumes = [volume_share(shape, value, subject, triangles) for shape, value in between(subject, shapes)]
        found.append((
            f"{name}, edges",
            f"median {np.median(ratios):.3f}, least 1% below {np.percentile(ratios, 1):.2f}, of what lies between the "
            "ends' lengths",
        ))  # fmt: skip
        if subject.mask is None:
            found.append((f"{name}, volume", f"{min(volumes):.3f} to {max(volumes):.3f} of the ends' mean"))
    return found


def between(subject, shapes):
    """(shape, value) of those that are no end."""
    return [(shape, value) for shape, value in zip(shapes, subject.values, strict=True) if 0.0 < value < 1.0]


def edges(polygons):
    pairs = np.concatenate([polygons[:, [corner, (corner + 1) % 4]] for corner in range(4)])
    return np.unique(np.sort(pairs, axis=1), axis=0)


def lengths(shape, ends):
    return np.linalg.norm(shape[ends[:, 0]] - shape[ends[:, 1]], axis=1)


def edge_ratios(shape, value, subject, ends):
    """Lengths over the geometric means of those at the ends, as a mix of `value` should have them."""
    share = np.full(len(ends), value) if subject.mask is None else value * subject.mask[ends].mean(axis=1)
    expected = lengths(subject.rest, ends) ** (1.0 - share) * lengths(subject.other, ends) ** share
    return lengths(shape, ends) / expected


def volume(shape, triangles):
    corners = shape.astype(float)[triangles]
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)


def volume_share(shape, value, subject, triangles):
    expected = (1.0 - value) * volume(subject.rest, triangles) + value * volume(subject.other, triangles)
    return volume(shape, triangles) / expected
