# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh an artist may want to mend, told in plain words and found again: none of it stops the solver."""

from dataclasses import dataclass

import numpy as np

from ... import wording
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
)


@dataclass(frozen=True, eq=False)
class Problem:
    """kind: of KINDS; text: count and what was counted; vertices: ascending indices, int."""

    kind: str
    text: str
    vertices: np.ndarray


def find(rest, triangles, report=None, places=None, partners=None, copies=None):
    """All Problems of n x 3 `rest` and m x 3 `triangles`, in the order of KINDS.

    report: the native one of a binding, which knows the parts; places: which vertex of what the solver gets each of
    the n is (BindInput.solver_mesh); partners: n int, the mirror image of each vertex, -1 for none; copies: as of
    scene/seams.py, which are no doubles.
    """
    rest = np.asarray(rest, np.float64)
    copies = np.arange(len(rest)) if copies is None else copies
    found = {
        'WIRE': _wire(len(rest), triangles),
        'DOUBLE': _doubles(rest, triangles, copies),
        'GAP': _gaping(rest, triangles, copies),
        'NO_AREA': _without_area(rest, triangles),
        **_of_edges(triangles),
        **({} if report is None else _of_parts(report, places)),
        'UNPAIRED': _unpaired(np.empty(0, int) if partners is None else partners),
    }
    return [Problem(kind, *found[kind]) for kind, *_ in KINDS if kind in found and len(found[kind][1])]


def _wire(count, triangles):
    lone = np.ones(count, bool)
    lone[triangles] = False
    vertices = np.flatnonzero(lone)
    return f"{wording.vertices(len(vertices))} without faces", vertices


def _unpaired(partners):
    vertices = np.flatnonzero(partners < 0)
    return f"{wording.vertices(len(vertices))} without a mirror image", vertices


def _doubles(rest, triangles, copies):
    used = np.unique(triangles)
    first = used[welding.first_of_place(rest[used], welding.rounding(rest))]
    # Of what lies in one place the solver gets so many vertices; all but one are doubles.
    found = np.unique(first.astype(np.int64) * len(rest) + copies[used])  # numpy 1 has 32 bits on Windows
    counts = np.bincount(found // max(1, len(rest)), minlength=len(rest))
    extra = int(np.maximum(0, counts - 1).sum())
    return f"{wording.counted(extra, 'doubled vertex', 'doubled vertices')}", used[counts[first] > 1]


def _gaping(rest, triangles, copies):
    faces = triangles.ravel(), np.arange(0, triangles.size, 3)
    vertices, pieces, distance = welding.gaping(rest, *faces, copies)
    where = f"{wording.vertices(len(vertices))} nearly in the place of others, of {wording.counted(pieces, 'piece')}"
    return f"{where} (Merge Distance {distance:g} joins them)", vertices


def _without_area(rest, triangles):
    first, second, third = (rest[triangles[:, number]] for number in range(3))
    edges = np.stack([second - first, third - second, first - third])
    areas = np.linalg.norm(np.cross(edges[0], edges[1]), axis=1)
    flat = areas <= NO_HEIGHT * (edges**2).sum(axis=2).max(axis=0)
    return f"{wording.counted(np.count_nonzero(flat), 'triangle')} without area", np.unique(triangles[flat])


def _of_edges(triangles):
    """{kind: (text, vertices)} of edges that both of their faces go along in one direction, and of those that more than
    two faces share."""
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)  # from corner to corner
    unordered = np.sort(edges, axis=1)
    uses, fin_count = _uses(unordered, most=2)
    ways, flipped_count = _uses(edges[uses == 2], most=1)
    flipped = f"{wording.counted(flipped_count, 'edge')} between faces that look to opposite sides"
    return {
        'FLIPPED': (flipped, np.unique(edges[uses == 2][ways == 2])),
        'FIN': (f"{wording.counted(fin_count, 'edge')} of more than two faces", np.unique(edges[uses > 2])),
    }


def _uses(edges, most):
    """(m int: how often each of m x 2 edges is there, how many are there more than `most` times)."""
    edges = edges.astype(np.int64)
    numbers = edges[:, 0] * (edges.max(initial=0) + 1) + edges[:, 1]
    _, of_each, counts = np.unique(numbers, return_inverse=True, return_counts=True)
    return counts[of_each.ravel()], np.count_nonzero(counts > most)


def _of_parts(report, places):
    """{kind: (text, vertices)} of what too little holds."""
    part_of = np.asarray(report.part_of)[places]
    parts = list(report.components)
    own = [k for k in np.unique(part_of) if k >= 0 and parts[k].free_count]  # the others are mirror images
    loose = [k for k in own if parts[k].undetermined == 7]
    unheld = [k for k in own if 0 < parts[k].undetermined < 7]
    return {
        'LOOSE': (
            f"{wording.counted(len(loose), 'part')} without a handle",
            np.flatnonzero(np.isin(part_of, loose)),
        ),
        'UNHELD': (
            f"{wording.counted(len(unheld), 'part')} held by too few points",
            np.flatnonzero(np.isin(part_of, unheld)),
        ),
    }
