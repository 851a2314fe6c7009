# SPDX-License-Identifier: GPL-3.0-or-later
"""Points in one place."""

import numpy as np

from ...solver.core.fingerprint import digest
from . import connected

#: A direction that neither edges nor planes of modelled meshes are at right angles to: along it they do not pile up.
_ALONG = np.array([0.5377, 0.3141, 0.7824])

#: Side of a cell, of the distance: whatever shares a cell is within the distance, rounding left aside.
_SIDE = 0.999 / 3.0**0.5

#: A distance below this share of the points' extent is none: cells could not be told from each other any more.
_LEAST_SHARE = 1e-12

#: So many pairs of points are compared at a time.
_AT_ONCE = 1 << 20

#: Results are remembered for so many points and distances: a mesh is read again after every edit of anything.
REMEMBERED = 4

_remembered = {}


def first_of_place(points, distance):
    """n int: for each of n x 3 points the lowest index of those that steps of at most `distance` lead to. Not to be
    written to.

    Cost: that of sorting, however many points are in one place.
    """
    key = digest(points, f"{distance!r}")
    if key not in _remembered:
        while len(_remembered) >= REMEMBERED:
            del _remembered[next(iter(_remembered))]
        _remembered[key] = _found(np.asarray(points, np.float64), distance)
        _remembered[key].flags.writeable = False
    return _remembered[key]


def _found(points, distance):
    roots = np.arange(len(points))
    near = _may_be_near(points, distance)
    if len(near) == 0:
        return roots
    points = points[near] + 0.0  # no -0
    if distance <= _LEAST_SHARE * np.ptp(points, axis=0).max():
        found = connected.parts(_groups(points).links(), len(points))
    else:
        found = _joined(points, distance)
    roots[near] = near[found]
    return roots


def _may_be_near(points, distance):
    """Ascending indices of the points that have another one no farther away in one direction."""
    along = points @ (_ALONG / np.linalg.norm(_ALONG))
    order = np.argsort(along, kind="stable")
    reach = distance + 1e-14 * np.abs(along).max(initial=0.0)  # rounding
    is_near = np.diff(along[order]) <= reach
    found = np.zeros(len(points), bool)
    found[order[1:][is_near]] = found[order[:-1][is_near]] = True
    return np.flatnonzero(found)


class _Groups:
    """Points with equal keys. order: their indices, group after group; begins, counts: of each group in it."""

    def __init__(self, order, is_new):
        self.order, self.begins = order, np.flatnonzero(is_new)
        self.counts = np.diff(np.append(self.begins, len(order)))

    def links(self):
        """Pairs of points that join those of each group."""
        return np.stack([np.repeat(self.order[self.begins], self.counts), self.order], axis=1)


def _groups(rows):
    """_Groups of equal rows of an integer or float array, ascending by the first column, then the second ..."""
    order = np.lexsort(rows.T[::-1])
    ordered = rows[order]
    return _Groups(order, np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1)))


def _joined(points, distance):
    """As first_of_place(), by cells: what shares one is joined, and what is in two of them as far as it is near."""
    numbers = _cells(points, distance)
    cells = _groups(numbers)
    roots = connected.parts(cells.links(), len(points))
    heads = cells.order[cells.begins]
    first, second = _neighbours(numbers[heads])
    ordered = points[cells.order]
    low, high = np.minimum.reduceat(ordered, cells.begins), np.maximum.reduceat(ordered, cells.begins)
    gaps = np.maximum(0.0, np.maximum(low[first] - high[second], low[second] - high[first]))
    spans = np.maximum(high[first] - low[second], high[second] - low[first])
    may_be = (gaps**2).sum(axis=1) <= distance**2
    is_near = (spans**2).sum(axis=1) <= distance**2
    connected.joined(roots, np.stack([heads[first[is_near]], heads[second[is_near]]], axis=1))
    open_pairs = np.flatnonzero(may_be & ~is_near)
    sizes = cells.counts[first[open_pairs]] * cells.counts[second[open_pairs]]
    open_pairs = open_pairs[np.argsort(sizes, kind="stable")]  # small ones are likely to join what large ones are of
    while len(open_pairs):
        open_pairs = open_pairs[roots[heads[first[open_pairs]]] != roots[heads[second[open_pairs]]]]
        sizes = np.cumsum(cells.counts[first[open_pairs]] * cells.counts[second[open_pairs]])
        now = int(np.searchsorted(sizes, _AT_ONCE))
        if now > 0:
            pairs = _near_pairs(ordered, cells, first[open_pairs[:now]], second[open_pairs[:now]], distance)
            connected.joined(roots, cells.order[pairs])
        elif len(open_pairs):
            now, (one, other) = 1, (each[open_pairs[0]] for each in (first, second))
            if _touch(_points_of(ordered, cells, one), _points_of(ordered, cells, other), distance):
                connected.joined(roots, heads[[[one, other]]])
        open_pairs = open_pairs[now:]
    return roots


def _points_of(ordered, cells, cell):
    return ordered[cells.begins[cell] : cells.begins[cell] + cells.counts[cell]]


def _touch(first, second, distance):
    """Whether any of k x 3 points is at most `distance` from one of l x 3: those that are near to the others' box are
    halved until few are left."""
    first = first[_box_distance(first, second) <= distance**2]
    second = second[_box_distance(second, first) <= distance**2] if len(first) else first
    if len(first) == 0 or len(second) == 0:
        return False
    if len(first) * len(second) <= _AT_ONCE:
        return bool((((first[:, None] - second[None]) ** 2).sum(axis=2) <= distance**2).any())
    spans = np.maximum(first.max(axis=0) - second.min(axis=0), second.max(axis=0) - first.min(axis=0))
    if (spans**2).sum() <= distance**2:
        return True
    large, small = (first, second) if len(first) >= len(second) else (second, first)
    large = large[np.argsort(large[:, int(np.ptp(large, axis=0).argmax())], kind="stable")]
    return any(_touch(half, small, distance) for half in np.array_split(large, 2))


def _box_distance(points, others):
    """Squared, of each point from the box around the others."""
    beside = np.maximum(0.0, np.maximum(points - others.max(axis=0), others.min(axis=0) - points))
    return (beside**2).sum(axis=1)


def _cells(points, distance):
    """n x 3 int64. Empty stretches are cut down to three cells, beyond which nothing is near: numbers are below 3 n."""
    numbers = np.floor((points - points.min(axis=0)) / (_SIDE * distance)).astype(np.int64)
    for axis in range(3):
        found, back = np.unique(numbers[:, axis], return_inverse=True)
        numbers[:, axis] = np.cumsum(np.minimum(np.diff(found, prepend=found[0]), 3))[back]
    return numbers


def _neighbours(cells):
    """(first, second): the pairs of c x 3 `cells`, which ascend, at most two apart along each axis."""
    deep = int(cells[:, 2].max()) + 6
    wide = int(cells[:, 1].max()) + 6
    columns, column = np.unique((cells[:, 0] + 2) * wide + cells[:, 1] + 2, return_inverse=True)
    keys = column * deep + cells[:, 2] + 2  # ascending
    firsts, seconds = [], []
    for across in range(3):
        for beside in range(-2, 3) if across else range(3):
            others = columns[column] + across * wide + beside
            place = np.minimum(np.searchsorted(columns, others), len(columns) - 1)
            asking = np.flatnonzero(columns[place] == others)
            middle = place[asking] * deep + cells[asking, 2] + 2
            is_own = across == beside == 0
            begin = np.searchsorted(keys, middle + 1 if is_own else middle - 2)
            end = np.searchsorted(keys, middle + 3)
            counts = end - begin
            firsts.append(np.repeat(asking, counts))
            seconds.append(np.arange(counts.sum()) + np.repeat(begin - np.cumsum(counts) + counts, counts))
    return np.concatenate(firsts), np.concatenate(seconds)


def _near_pairs(ordered, cells, first, second, distance):
    """p x 2 places in `ordered`, the points cell after cell: those of pairs of cells that are near to each other."""
    seconds = cells.counts[second]
    counts = cells.counts[first] * seconds
    pair = np.repeat(np.arange(len(first)), counts)
    number = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    one = cells.begins[first][pair] + number // seconds[pair]
    other = cells.begins[second][pair] + number % seconds[pair]
    near = ((ordered[one] - ordered[other]) ** 2).sum(axis=1) <= distance**2
    return np.stack([one[near], other[near]], axis=1)
