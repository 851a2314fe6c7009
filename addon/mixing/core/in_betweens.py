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

#: Settings of the sliders, drawn evenly, at which the interpolation is compared with the mix itself; and those at which
#: the nodes that were chosen by these are looked at afterwards, so often at most.
CHECKS = 48
HELD_OUT = 32
MOST_LOOKS = 4

#: The search ends where no check is farther off than this share of the tolerance: between checks it may be more.
ROOM = 0.9

#: So many times as many nodes are searched as are allowed in the end: most of them turn out not to be needed.
SEARCHED = 4

#: What is expected of the next polynomial of a slider, as a share of what the one before adds together with others.
NEXT = 0.3

#: Of the error with half as many nodes, what is left where more nodes would help.
STILL_FALLS = 0.75

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

    Where the error is above the tolerance: used_up, the numbers of the sliders that have a node at each of their places
    and would need more; would_more_help, whether nodes beyond the most that were allowed would bring it down.
    """

    nodes: tuple
    error: float
    used_up: tuple = ()
    would_more_help: bool = False


class Interpolation:
    """The sum of nodes. knots: for each slider the places of leja.places()."""

    def __init__(self, knots, shape, nodes=()):
        self.knots = knots
        self.nodes = list(nodes)
        self.shape = shape

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
        result = np.zeros(self.shape)
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
    checks, count, goal = [], CHECKS, 0.5 * tolerance
    nothing = NOTHING * tolerance
    chosen = search.sum
    for _ in range(MOST_LOOKS):
        while True:
            yield from search.refine(goal, SEARCHED * most)
            is_near = yield from _is_near(search.sum, checks, ranges, count, ROOM * tolerance)
            if is_near or len(search.sum.nodes) >= SEARCHED * most or not search.has_candidates(nothing):
                break
            goal *= 0.5
        if not is_near:
            break
        chosen = _thinned(search.sum, checks, tolerance, most)
        count += HELD_OUT
        if (yield from _is_near(chosen, checks, ranges, count, tolerance)):
            return Found(tuple(chosen.nodes), _error(chosen, checks))
    while len(checks) < count:  # so that what is left is told of all
        yield from _check(checks, ranges)
    errors = _errors(search.sum, checks)
    # What is no smooth motion may become worse by more nodes.
    best = Interpolation(search.sum.knots, shape, search.sum.nodes[: int(np.argmin(errors))])
    chosen = _thinned(best, checks, tolerance, most)
    error = _error(chosen, checks)
    used_up = search.used_up(tolerance)
    are_few = len(errors) <= leja.MOST * len(ranges)  # to tell by what they have brought
    still_falls = search.has_candidates(nothing) and (are_few or errors[-1] <= STILL_FALLS * errors[len(errors) // 2])
    would_more_help = not used_up and (still_falls or min(errors) <= STILL_FALLS * error)
    return Found(tuple(chosen.nodes), error, used_up, would_more_help)


def _is_near(interpolation, checks, ranges, count, distance):
    """Whether none of `count` checks is farther off. Solves those that are not there yet, as long as that is so."""
    for number in range(count):
        if number == len(checks):
            yield from _check(checks, ranges)
        values, truth = checks[number]
        if _height(truth - interpolation.at(values)) > distance:
            return False
    return True


def _check(checks, ranges):
    """Solves one more."""
    values = _setting(ranges, len(checks))
    checks.append((values, (yield values)))


def _error(interpolation, checks):
    return max((_height(truth - interpolation.at(values)) for values, truth in checks), default=0.0)


def _errors(interpolation, checks):
    """With none of the nodes, with the first, with the first two, ..."""
    left = [truth.copy() for _values, truth in checks]
    errors = [max(map(_height, left))]
    for node in interpolation.nodes:
        for rest, (values, _truth) in zip(left, checks, strict=True):
            weight = interpolation.weight(node.orders, values)
            if weight:
                rest -= weight * node.offset
        errors.append(max(map(_height, left)))
    return errors


class _Search:
    """Nodes that were taken, and those next to them that were looked at."""

    def __init__(self, interpolation, may_join):
        self.sum = interpolation
        self._may_join = may_join
        self._taken = {()}
        self._candidates = {}  # orders: offset
        self._with_others = {}  # orders: height of the largest node that was taken of these and more sliders
        self._sliders = range(len(interpolation.knots))
        self._must_look = [((slider, 1),) for slider in self._sliders]

    def has_candidates(self, least):
        """Whether any would add more than that."""
        return bool(self._must_look) or any(self._rank(each) > least for each in self._candidates)

    def used_up(self, tolerance):
        """The sliders that have a node at each of their places, the last of which still changed the mix."""
        last = {node.orders[0][0]: node.height for node in self.sum.nodes if _is_last(node.orders)}
        return tuple(slider for slider in self._sliders if last.get(slider, 0.0) > tolerance)

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
        """What it adds, or what may be behind it: nothing may show along one slider alone of what it does to others.

        What lies on one slider alone is always looked at once between its ends, where nothing shows at these.
        """
        if len(orders) == 1 and orders[0][1] == 1:
            return np.inf
        return max(_height(self._candidates[orders]), NEXT * self._together(orders))

    def _together(self, orders):
        """The most that was added by a node with one polynomial less and by other sliders as well."""
        return max((self._with_others.get(before, 0.0) for before in _before(orders)), default=0.0)

    def _take(self, orders):
        offset = self._candidates.pop(orders)
        node = InBetween(orders, offset)
        self.sum.nodes.append(node)
        self._taken.add(orders)
        height = node.height
        for number in range(1, len(orders)):
            for some in itertools.combinations(orders, number):
                self._with_others[some] = max(height, self._with_others.get(some, 0.0))
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


def _is_last(orders):
    return len(orders) == 1 and orders[0][1] == leja.MOST - 1


def _before(orders):
    """All nodes with one polynomial less."""
    for index, (slider, number) in enumerate(orders):
        less = ((slider, number - 1),) if number > 1 else ()
        yield (*orders[:index], *less, *orders[index + 1 :])


def _thinned(interpolation, checks, tolerance, most):
    """An Interpolation without the nodes that are not needed at any check, and with `most` of them at most."""
    nodes = interpolation.nodes
    heights = [node.height for node in nodes]
    left = [truth - interpolation.at(values) for values, truth in checks]
    dropped = set()
    for index in sorted(range(len(nodes)), key=heights.__getitem__):
        most_left = np.inf if heights[index] <= NOTHING * tolerance else ROOM * tolerance
        without = _without(interpolation, nodes[index], left, checks, most_left)
        if without is not None:
            left = without
            dropped.add(index)
    kept = [index for index in range(len(nodes)) if index not in dropped]
    kept = sorted(sorted(kept, key=lambda index: -heights[index])[:most])
    return Interpolation(interpolation.knots, interpolation.shape, [nodes[index] for index in kept])


def _without(interpolation, node, left, checks, most_left):
    """What is left at each check without a node, or None where that is more than `most_left` anywhere."""
    without = []
    for rest, (values, _truth) in zip(left, checks, strict=True):
        weight = interpolation.weight(node.orders, values)
        without.append(rest + weight * node.offset if weight else rest)
        if _height(without[-1]) > most_left:
            return None
    return without


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
