# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a mesh, told in plain words and found again: none of it stops the solver."""

from dataclasses import dataclass

import numpy as np

from . import coincidence, fixed_points, wording

#: Vertices nearer to each other than this share of the size lie in one place.
SAME_PLACE = 1e-7
#: A triangle lower than this share of its longest edge has no area.
NO_HEIGHT = 1e-6
#: The native module's name of what is joined in a point.
PINCHED = "non-manifold"
#: A vertex is crowded whose edges are shorter than this share of those of most vertices.
CROWDED = 0.01

#: Kinds of problems: identifier, name, what it means.
KINDS = (
    ('LOOSE', "No Handle", "Parts that no handle, pin or fixed vertex holds: they follow others, or stay"),
    ('UNHELD', "Too Few Points", "Parts held by fewer than three points, or by points in one line"),
    ('WIRE', "Without Faces", "Vertices of loose edges, and single ones: only faces tell the shape"),
    ('DOUBLE', "Doubles", "Vertices in the place of others: an open seam, or a copied part. Merge Distance closes it"),
    ('NO_AREA', "Faces Without Area", "Faces whose corners lie in one line or in one place"),
    ('TWICE', "Duplicate Faces", "Faces with the same corners as another face"),
    ('FLIPPED', "Flipped Faces", "Neighbouring faces that look to opposite sides"),
    ('FIN', "More Than Two Faces", "Edges that more than two faces share"),
    ('PINCHED', "Joined at a Point", "Vertices that two pieces of surface share without a common edge"),
    ('CROWDED', "Tiny Edges", "Vertices whose edges are a hundred times as short as those of most others"),
    ('FALLBACK', "Hard to Encode", "Vertices whose surroundings hardly tell their place: borders, folds, needles"),
)


@dataclass(frozen=True, eq=False)
class Problem:
    """kind: of KINDS; count and what was counted; vertices: ascending indices, int."""

    kind: str
    text: str
    vertices: np.ndarray


def find(rest, triangles, report=None, places=None):
    """All Problems of n x 3 `rest` and m x 3 `triangles`, in the order of KINDS.

    report: the native one of a binding, which knows some of them; places: which of its vertices each of the n is.
    """
    rest = np.asarray(rest, np.float64)
    corners = rest[triangles]
    found = {
        'WIRE': _wire(len(rest), triangles),
        'DOUBLE': _doubles(rest, triangles),
        'NO_AREA': _without_area(corners, triangles),
        'CROWDED': _crowded(rest, triangles),
        **_of_edges(triangles),
    }
    if report is not None:
        found.update(_of_report(report, np.arange(len(rest)) if places is None else places))
    return [Problem(kind, *found[kind]) for kind, *_ in KINDS if kind in found and len(found[kind][1])]


def text(problems):
    """One sentence for all, or nothing."""
    if problems:
        yield f"Found {wording.listed([each.text for each in problems])}. Select Problem Vertices shows where"


def _wire(count, triangles):
    lone = np.ones(count, bool)
    lone[triangles] = False
    vertices = np.flatnonzero(lone)
    return f"{wording.vertices(len(vertices))} without faces", vertices


def _doubles(rest, triangles):
    used = np.unique(triangles)
    distance = SAME_PLACE * fixed_points.bounding_box_diagonal(rest)
    first = coincidence.first_of_place(rest[used], distance)
    is_double = np.isin(first, first[first != np.arange(len(used))])
    extra = np.count_nonzero(first != np.arange(len(used)))
    return f"{wording.counted(extra, 'doubled vertex', 'doubled vertices')}", used[is_double]


def _without_area(corners, triangles):
    edges = corners - np.roll(corners, 1, axis=1)
    longest = (edges**2).sum(axis=2).max(axis=1, initial=0.0)
    areas = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    flat = areas <= NO_HEIGHT * longest
    return f"{wording.counted(np.count_nonzero(flat), 'triangle')} without area", np.unique(triangles[flat])


def _crowded(rest, triangles):
    edges = _edges(triangles)
    lengths = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    ends = edges.ravel()
    means = np.bincount(ends, np.repeat(lengths, 2), len(rest)) / np.maximum(1, np.bincount(ends, minlength=len(rest)))
    used = means > 0.0
    if not used.any():
        return "", np.empty(0, int)
    crowded = np.flatnonzero(used & (means < CROWDED * np.median(means[used])))
    return f"{wording.vertices(len(crowded))} with tiny edges", crowded


def _edges(triangles):
    """3 m x 2: of each triangle those from corner to corner."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def _of_edges(triangles):
    """What faces that are there twice, look to opposite sides or are one too many at an edge have in common: edges that
    are gone along twice in one direction."""
    count = int(triangles.max(initial=-1)) + 1
    edges = _edges(triangles).astype(np.int64)
    directed = np.sort(edges[:, 0] * count + edges[:, 1])
    if not (directed[1:] == directed[:-1]).any():
        return {}
    _, first, repeats = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True, return_counts=True)
    again = np.ones(len(triangles), bool)
    again[first] = False
    single = triangles[~again]
    edges = _edges(single).astype(np.int64)
    directed = edges[:, 0] * count + edges[:, 1]
    low, high = edges.min(axis=1), edges.max(axis=1)
    _, of_edge, uses = np.unique(low * count + high, return_inverse=True, return_counts=True)
    uses = uses[of_edge.ravel()]
    _, of_directed, ways = np.unique(directed, return_inverse=True, return_counts=True)
    turned = (ways[of_directed.ravel()] == 2) & (uses == 2)
    fins = uses > 2
    fin_count = len(np.unique(low[fins] * count + high[fins]))
    turned_count = np.count_nonzero(turned) // 2
    return {
        'TWICE': (
            f"{wording.counted(int(again.sum()), 'duplicate triangle')}",
            np.unique(triangles[first[repeats > 1]]),
        ),
        'FLIPPED': (
            f"{wording.counted(turned_count, 'edge')} between faces that look to opposite sides",
            np.unique(edges[turned]),
        ),
        'FIN': (f"{wording.counted(fin_count, 'edge')} of more than two faces", np.unique(edges[fins])),
    }


def _of_report(report, places):
    part_of = np.asarray(report.part_of)[places]
    parts = list(report.components)
    loose = [k for k, part in enumerate(parts) if part.free_count and part.undetermined == 7]
    unheld = [k for k, part in enumerate(parts) if part.free_count and 0 < part.undetermined < 7]
    by_reason = report.guarded_by_reason
    guarded = np.zeros(len(report.part_of), bool)
    guarded[list(report.guarded)] = True
    is_pinched = np.zeros(len(guarded), bool)
    is_pinched[list(by_reason.get(PINCHED, []))] = True
    pinched, others = np.flatnonzero(is_pinched[places]), np.flatnonzero((guarded & ~is_pinched)[places])
    return {
        'LOOSE': (
            f"{wording.counted(len(loose), 'part')} without a handle",
            np.flatnonzero(np.isin(part_of, loose)),
        ),
        'UNHELD': (
            f"{wording.counted(len(unheld), 'part')} held by too few points",
            np.flatnonzero(np.isin(part_of, unheld)),
        ),
        'PINCHED': (f"{wording.vertices(len(pinched))} where surfaces meet in a point", pinched),
        'FALLBACK': (f"{wording.vertices(len(others))} encoded by a fallback rule", others),
    }
