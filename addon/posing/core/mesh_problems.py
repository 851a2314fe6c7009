# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a mesh, told in plain words and found again: none of it stops the solver."""

from dataclasses import dataclass

import numpy as np

from ... import wording
from ...scene.core import fixed_points
from ...solver.core.steps import result_of
from . import welding

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

    report: the native one of a binding, which knows some of them; places: which vertex of what the solver gets each of
    the n is (BindInput.solver_mesh). Doubles that are one there are none.
    """
    return result_of(search(rest, triangles, report, places))


def search(rest, triangles, report=None, places=None):
    """Generator of the share that is done, 0 to 1, after each bit of work; returns what find() does."""
    rest = np.asarray(rest, np.float64)
    places = np.arange(len(rest)) if places is None else places
    found = {'WIRE': _wire(len(rest), triangles)}
    yield 0.1
    found['DOUBLE'] = _doubles(rest, triangles, places)
    yield 0.3
    found['NO_AREA'] = _without_area(rest, triangles)
    yield 0.5
    found['CROWDED'] = _crowded(rest, triangles)
    yield 0.6
    if _has_repeated_edges(triangles):
        yield 0.7
        found['TWICE'], single = _twice(triangles)
        yield 0.8
        found['FLIPPED'], found['FIN'] = _of_edges(single)
    yield 0.9
    if report is not None:
        found.update(_of_report(report, places))
    return [Problem(kind, *found[kind]) for kind, *_ in KINDS if kind in found and len(found[kind][1])]


#: What a binding's summary and its other notes tell already.
_TOLD_OTHERWISE = {'LOOSE', 'UNHELD', 'FALLBACK'}


def text(problems):
    """One sentence for all that Bind does not tell otherwise, or nothing."""
    problems = [each for each in problems if each.kind not in _TOLD_OTHERWISE]
    if problems:
        yield f"Found {wording.listed([each.text for each in problems])}. Select Problem Vertices shows where"


def _wire(count, triangles):
    lone = np.ones(count, bool)
    lone[triangles] = False
    vertices = np.flatnonzero(lone)
    return f"{wording.vertices(len(vertices))} without faces", vertices


def _doubles(rest, triangles, places):
    is_used = np.zeros(len(rest), bool)
    is_used[triangles] = True
    used = np.flatnonzero(is_used)
    distance = SAME_PLACE * fixed_points.bounding_box_diagonal(rest)
    first = welding.first_of_place(rest[used], distance)
    apart = np.flatnonzero(first != np.arange(len(used)))
    if len(apart) == 0:
        return "", apart
    # Of what lies in one place the solver gets so many vertices; all but one are doubles.
    count = int(places.max()) + 1
    first = first.astype(np.int64)  # numpy 1 has 32 bits on Windows
    counts = np.bincount(np.unique(first * count + places[used]) // count, minlength=len(used))
    extra = int(np.maximum(0, counts - 1).sum())
    is_double = counts[first] > 1
    return f"{wording.counted(extra, 'doubled vertex', 'doubled vertices')}", used[is_double]


def _without_area(rest, triangles):
    corners = [rest.T[:, triangles[:, number]] for number in range(3)]  # 3 x m each: columns are quicker than rows
    edges = [corners[number] - corners[number - 1] for number in range(3)]
    longest = np.max([(edge**2).sum(axis=0) for edge in edges], axis=0)
    (x, y, z), (u, v, w) = edges[:2]
    areas = np.sqrt((y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2)
    flat = areas <= NO_HEIGHT * longest
    return f"{wording.counted(np.count_nonzero(flat), 'triangle')} without area", np.unique(triangles[flat])


def _crowded(rest, triangles):
    sums, counts, columns = np.zeros(len(rest)), np.zeros(len(rest), int), rest.T
    for number in range(3):
        start, end = triangles[:, number - 1], triangles[:, number]
        lengths = np.sqrt(((columns[:, start] - columns[:, end]) ** 2).sum(axis=0))
        for ends in (start, end):
            sums += np.bincount(ends, lengths, len(rest))
            counts += np.bincount(ends, minlength=len(rest))
    means = sums / np.maximum(1, counts)
    used = means > 0.0
    if not used.any():
        return "", np.empty(0, int)
    crowded = np.flatnonzero(used & (means < CROWDED * np.median(means[used])))
    return f"{wording.vertices(len(crowded))} with tiny edges", crowded


def _edges(triangles):
    """3 m x 2: of each triangle those from corner to corner."""
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)


def _has_repeated_edges(triangles):
    """What faces that are there twice, look to opposite sides or are one too many at an edge have in common: edges that
    are gone along twice in one direction."""
    count = int(triangles.max(initial=-1)) + 1
    edges = _edges(triangles).astype(np.int64)
    directed = np.sort(edges[:, 0] * count + edges[:, 1])
    return bool((directed[1:] == directed[:-1]).any())


def _twice(triangles):
    """((text, vertices) of faces that are there again, the triangles without them)."""
    low, middle, high = np.sort(triangles, axis=1).T
    order = np.lexsort((high, middle, low))  # stable: the first of equal ones comes first
    alike = np.stack([low, middle, high], axis=1)[order]
    is_again = np.append(False, (alike[1:] == alike[:-1]).all(axis=1))
    again = order[is_again]
    text = f"{wording.counted(len(again), 'duplicate triangle')}"
    return (text, np.unique(triangles[again])), np.delete(triangles, again, axis=0)


def _of_edges(triangles):
    """(text, vertices) each of edges of faces that look to opposite sides, and of those that more than two share.

    triangles: none of them twice.
    """
    count = int(triangles.max(initial=-1)) + 1
    edges = _edges(triangles).astype(np.int64)
    directed = edges[:, 0] * count + edges[:, 1]
    low, high = np.minimum(*edges.T), np.maximum(*edges.T)
    _, of_edge, uses = np.unique(low * count + high, return_inverse=True, return_counts=True)
    uses = uses[of_edge.ravel()]
    _, of_directed, ways = np.unique(directed, return_inverse=True, return_counts=True)
    turned = (ways[of_directed.ravel()] == 2) & (uses == 2)
    fins = uses > 2
    fin_count = len(np.unique(low[fins] * count + high[fins]))
    turned_count = np.count_nonzero(turned) // 2
    flipped = f"{wording.counted(turned_count, 'edge')} between faces that look to opposite sides"
    return (
        (flipped, np.unique(edges[turned])),
        (f"{wording.counted(fin_count, 'edge')} of more than two faces", np.unique(edges[fins])),
    )


def _of_report(report, places):
    part_of = np.asarray(report.part_of)[places]
    parts = list(report.components)
    own = [k for k in np.unique(part_of) if k >= 0 and parts[k].free_count]  # the others are mirror images
    loose = [k for k in own if parts[k].undetermined == 7]
    unheld = [k for k in own if 0 < parts[k].undetermined < 7]
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
