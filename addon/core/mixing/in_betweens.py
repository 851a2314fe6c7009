# SPDX-License-Identifier: GPL-3.0-or-later
"""As few shapes as it takes to stand for a mix of sliders, each with a polynomial of the sliders as its weight.

Adaptive interpolation on sparse grids of Leja points (Chkifa, Cohen, Schwab 2014), from the rest shape: a node is a
place of one slider or of several at once, all others at 0. What it adds is the difference between the mix there and
what the nodes before it say, so that adding one changes nothing at the places of those that are there.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from . import drivers, leja

#: Nodes of so small a share of the tolerance are left out.
NOTHING = 1e-3

#: Settings of the sliders, drawn evenly, at which the interpolation is compared with the mix itself.
CHECKS = 64

#: Sliders that are at work in one node.
MOST_SLIDERS = 3


@dataclass(frozen=True, eq=False)
class InBetween:
    """A node: {number of the slider: number of the polynomial of leja.py}, and n x 3 float64 that it adds."""

    orders: tuple
    offset: np.ndarray

    @property
    def height(self):
        return _height(self.offset)


@dataclass(frozen=True, eq=False)
class Found:
    """nodes: tuple of InBetween; error: the largest distance of a vertex from the mix, at CHECKS settings.

    used_up: the numbers of the sliders on which there is no place left for another node, where that ended the search.
    """

    nodes: tuple
    error: float
    used_up: tuple = ()


class Interpolation:
    """The sum of nodes. knots: for each slider the places of leja.places()."""

    def __init__(self, knots, shape):
        self.knots = knots
        self.nodes = []
        self._shape = shape

    def place(self, orders):
        """(k,): the sliders at a node."""
        values = np.zeros(len(self.knots))
        for slider, number in orders:
            values[slider] = self.knots[slider][number]
        return values

    def weight(self, orders, values):
        """Of a node with the sliders at `values`."""
        return float(np.prod([leja.value(self.knots[slider], number, values[slider]) for slider, number in orders]))

    def at(self, values):
        """n x 3."""
        result = np.zeros(self._shape)
        for node in self.nodes:
            weight = self.weight(node.orders, values)
            if weight:
                result += weight * node.offset
        return result


def found(ranges, shape, tolerance, most, may_join=lambda _first, _second: True):
    """Generator of slider settings, (k,) float64, whose correction is to be sent in, (n, 3). Returns a Found.

    What is sent in is 0 with all sliders at 0. ranges: [(low, high)] of the sliders; shape: (n, 3); tolerance: a
    distance; most: nodes at most; may_join(a, b): whether sliders a and b may change each other's effect.
    """
    search = _Search(Interpolation([leja.places(*each) for each in ranges], shape), may_join)
    checks = []
    goal = 0.5 * tolerance
    while True:
        yield from search.refine(goal, most)
        error = 0.0
        for number in range(CHECKS):
            if number == len(checks):
                values = _setting(ranges, number)
                checks.append((values, (yield values)))
            values, truth = checks[number]
            error = max(error, _height(truth - search.sum.at(values)))
            if error > tolerance:
                break
        if error <= tolerance or len(search.sum.nodes) >= most or not search.has_candidates:
            break
        goal *= 0.5
    used_up = search.used_up if error > tolerance and len(search.sum.nodes) < most else ()
    nodes = _thinned(search.sum, checks, tolerance)
    return Found(tuple(nodes), max((_height(t - search.sum.at(v)) for v, t in checks), default=0.0), used_up)


class _Search:
    """Nodes that were taken, and those next to them that were looked at."""

    def __init__(self, interpolation, may_join):
        self.sum = interpolation
        self._may_join = may_join
        self._taken = {()}
        self._candidates = {}  # orders: offset
        self._sliders = range(len(interpolation.knots))
        self._must_look = [((slider, 1),) for slider in self._sliders]

    @property
    def has_candidates(self):
        return bool(self._candidates or self._must_look)

    @property
    def used_up(self):
        """The sliders that have a node at each of their places."""
        return tuple(slider for slider in self._sliders if ((slider, leja.MOST - 1),) in self._taken)

    def refine(self, goal, most):
        """Takes the candidate that adds most until none adds more than `goal`."""
        while True:
            while self._must_look:
                orders = self._must_look.pop(0)
                values = self.sum.place(orders)
                self._candidates[orders] = (yield values) - self.sum.at(values)
            if not self._candidates or len(self.sum.nodes) >= most:
                return
            orders = max(self._candidates, key=lambda each: (self._rank(each), each))
            if self._rank(orders) <= goal:
                return
            self._take(orders)

    def _rank(self, orders):
        """What lies on one slider alone is always looked at once between its ends, where nothing shows at these."""
        if len(orders) == 1 and orders[0][1] == 1:
            return np.inf
        return _height(self._candidates[orders])

    def _take(self, orders):
        offset = self._candidates.pop(orders)
        node = InBetween(orders, offset)
        self.sum.nodes.append(node)
        self._taken.add(orders)
        for other, former in self._candidates.items():  # the sum is another one now
            weight = self.sum.weight(orders, self.sum.place(other))
            if weight:
                self._candidates[other] = former - weight * offset
        for new in self._next_to(dict(orders)):
            if all(before in self._taken for before in _before(new)):
                self._must_look.append(new)

    def _next_to(self, orders):
        for slider in self._sliders:
            number = orders.get(slider, 0) + 1
            if number >= leja.MOST or (number == 1 and len(orders) >= MOST_SLIDERS):
                continue
            if number == 1 and not all(self._may_join(slider, other) for other in orders):
                continue
            new = tuple(sorted({**orders, slider: number}.items()))
            if drivers.fits(self.sum.knots, new):
                yield new


def _before(orders):
    """All nodes with one polynomial less."""
    for index, (slider, number) in enumerate(orders):
        less = ((slider, number - 1),) if number > 1 else ()
        yield (*orders[:index], *less, *orders[index + 1 :])


def _thinned(interpolation, checks, tolerance):
    """The nodes without those that are not needed at any check; `interpolation` is left with these."""
    heights = [node.height for node in interpolation.nodes]
    left = [truth - interpolation.at(values) for values, truth in checks]
    for index in sorted(range(len(heights)), key=heights.__getitem__):
        node = interpolation.nodes[index]
        if heights[index] > tolerance:
            break
        without = [
            rest + interpolation.weight(node.orders, values) * node.offset
            for rest, (values, _) in zip(left, checks, strict=True)
        ]
        if heights[index] <= NOTHING * tolerance or all(_height(each) <= 0.9 * tolerance for each in without):
            left = without
            heights[index] = 0.0
    kept = [node for node, height in zip(interpolation.nodes, heights, strict=True) if height]
    interpolation.nodes = kept
    return kept


def _setting(ranges, number):
    """(k,): the points of a Kronecker sequence, which fill the box evenly. No two depend on each other."""
    roots = np.sqrt(list(itertools.islice(_primes(), len(ranges))))
    shares = (0.5 + (number + 1) * roots) % 1.0
    low, high = np.array(ranges, np.float64).T
    return low + shares * (high - low)


def _primes():
    for number in itertools.count(2):
        if all(number % other for other in range(2, int(number**0.5) + 1)):
            yield number


def _height(offset):
    return float(np.sqrt(np.einsum("ij,ij->i", offset, offset).max(initial=0.0)))
