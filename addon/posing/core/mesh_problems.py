# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh an artist may want to mend, told in plain words and found again: none of it stops the solver."""

import numpy as np

from ...scene.core import welding

#: A triangle lower than this share of its longest edge has no area.
NO_HEIGHT = 1e-6

#: Kinds of problems: identifier, name, what it means.
KINDS = (
    ('LOOSE', "No Handle", "Parts that no handle, pin or fixed vertex holds: they follow others, or stay"),
    ('UNHELD', "Too Few Points", "Parts held by fewer than three points, or by points in one line"),
    ('WIRE', "Without Faces", "Vertices of loose edges, and single ones: only faces tell the shape"),
    ('DOUBLE', "Doubles", "Vertices in the place of others that move apart: a copied part. Merge Distance joins it"),
    ('GAP', "Gaps", "Vertices of open borders nearly in the place of others. Merge Distance closes them"),
    ('NO_AREA', "Faces Without Area", "Faces whose corners lie in one line or in one place"),
    ('FLIPPED', "Flipped Faces", "Neighboring faces that look to opposite sides"),
    ('FIN', "More Than Two Faces", "Edges that more than two faces share, and those of faces that are there twice"),
    ('UNPAIRED', "Unpaired", "Vertices without a mirror image across the axis of Symmetric"),
    ('BAKED', "Off as Baked", "Where bones are off by over half their largest error, at its frame, after Bake"),
)


def find(rest, triangles, report=None, places=None, partners=None, copies=None):
    """({kind: ascending vertex indices, int} of n x 3 `rest` and m x 3 `triangles`, of what there is, in the order of
    KINDS; the merge distance that closes the gaps).

    report: the native one of a binding, which knows the parts; places: which vertex of what the solver gets each of
    the n is (BindInput.solver_mesh); partners: n int, the mirror image of each vertex, -1 for none; copies: as of
    scene/kept.py, which are no doubles.
    """
    rest = np.asarray(rest, np.float64)
    copies = np.arange(len(rest)) if copies is None else copies
    is_lone = np.ones(len(rest), bool)
    is_lone[triangles] = False
    gaps, distance = welding.gaping(rest, triangles.ravel(), np.arange(0, triangles.size, 3), copies)
    first, second, third = (rest[triangles[:, number]] for number in range(3))
    edges = np.stack([second - first, third - second, first - third])
    areas = np.linalg.norm(np.cross(edges[0], edges[1]), axis=1)
    found = {
        'WIRE': np.flatnonzero(is_lone),
        'DOUBLE': _doubles(rest, triangles, copies),
        'GAP': gaps,
        'NO_AREA': np.unique(triangles[areas <= NO_HEIGHT * (edges**2).sum(axis=2).max(axis=0)]),
        **_of_edges(triangles),
        **({} if report is None else _of_parts(report, places)),
        'UNPAIRED': np.flatnonzero(partners < 0) if partners is not None else (),
    }
    return {kind: found[kind] for kind, *_ in KINDS if len(found.get(kind, ()))}, distance


def _doubles(rest, triangles, copies):
    used = np.unique(triangles)
    first = used[welding.first_of_place(rest[used], welding.rounding(rest))]
    # Of what lies in one place the solver gets so many vertices; all but one are doubles.
    found = np.unique(first.astype(np.int64) * len(rest) + copies[used])  # numpy 1 has 32 bits on Windows
    counts = np.bincount(found // max(1, len(rest)), minlength=len(rest))
    return used[counts[first] > 1]


def _of_edges(triangles):
    """{kind: vertices} of edges that both faces go along in one direction, and of those that more than two share."""
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)  # from corner to corner
    uses = _uses(np.sort(edges, axis=1))
    of_two = edges[uses == 2]
    return {'FLIPPED': np.unique(of_two[_uses(of_two) == 2]), 'FIN': np.unique(edges[uses > 2])}


def _uses(edges):
    """m int: how often each of m x 2 edges is there."""
    edges = edges.astype(np.int64)
    numbers = edges[:, 0] * (edges.max(initial=0) + 1) + edges[:, 1]
    _, of_each, counts = np.unique(numbers, return_inverse=True, return_counts=True)
    return counts[of_each.ravel()]


def _of_parts(report, places):
    """{kind: vertices} of what too little holds."""
    part_of = np.asarray(report.part_of)[places]
    parts = list(report.components)
    own = [k for k in np.unique(part_of) if k >= 0 and parts[k].free_count]  # the others are mirror images
    loose = [k for k in own if parts[k].undetermined == 7]
    unheld = [k for k in own if 0 < parts[k].undetermined < 7]
    return {'LOOSE': np.flatnonzero(np.isin(part_of, loose)), 'UNHELD': np.flatnonzero(np.isin(part_of, unheld))}
