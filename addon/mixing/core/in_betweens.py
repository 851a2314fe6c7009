# SPDX-License-Identifier: GPL-3.0-or-later
"""As few shapes as it takes to stand for a mix of sliders, each with a polynomial of the sliders as its weight.

The mix is solved at settings that fill the box of the sliders. Polynomials are taken one after the other, that which
explains most of what is left (orthogonal matching pursuit: Pati, Rezaiifar, Krishnaprasad 1993), from those next to
what was taken. Their shapes are the least squares fit. Settings that had no say in it are what the fit is judged by.
"""

import bisect
import itertools
from dataclasses import dataclass

import numpy as np

from . import polynomials

#: Settings that are solved at first, and those that a fit is judged by. If it fails there, they have a say in the next.
FIRST, HELD_OUT = 48, 32

#: A fit has so many settings for each shape at least, or it would swing between them.
SETTINGS_PER_SHAPE = 3

#: A fit is good where no setting is farther off than this share of the tolerance: between them it may be more.
ROOM = 0.7

#: Sliders that are at work in one shape.
MOST_SLIDERS = 3

#: What is left of a polynomial beside those that were taken must be more than this to be told from rounding.
INDEPENDENT = 1e-6


@dataclass(frozen=True, eq=False)
class InBetween:
    """orders: as of polynomials.py; offset: n x 3 float64 that is added with this weight."""

    orders: tuple
    offset: np.ndarray


@dataclass(frozen=True, eq=False)
class Found:
    """shapes: tuple of InBetween; error: the largest distance of a vertex from the mix, at all settings solved."""

    shapes: tuple
    error: float


def found(solve, ranges, tolerance, most, may_join=lambda _first, _second: True):
    """Steps to a Found. solve(values): steps to the correction, (n, 3), at slider settings (k,); at 0 it is 0.

    ranges: [(low, high)] of the sliders; tolerance: a distance; most: shapes at most; may_join(a, b): whether sliders a
    and b may change each other's effect: where all may, the search takes 30 times as long with 24 that do not.
    """
    knots = [polynomials.places(*each) for each in ranges]
    settings, corrections = [], []

    def look(count):
        for number in range(len(settings), count):
            settings.append(_setting(ranges, knots, number))
            corrections.append(np.ravel((yield from solve(settings[-1]))))

    count, enough = FIRST + len(ranges), SETTINGS_PER_SHAPE * most + 4 * HELD_OUT
    while True:
        yield from look(count)
        fit = _Fit(knots, np.array(settings), np.array(corrections), may_join)
        orders, offsets, error = fit.grown(ROOM * tolerance, min(most, count // SETTINGS_PER_SHAPE))
        is_near = error <= ROOM * tolerance
        if is_near:
            yield from look(count + HELD_OUT)
            weights = _weights(knots, orders, np.array(settings))
            error = _height(np.array(corrections) - weights @ offsets)
        if count >= enough or (is_near and error <= tolerance):
            shapes = zip(orders, [offset.reshape(-1, 3) for offset in offsets], strict=True)
            return Found(tuple(InBetween(*each) for each in shapes), error)
        count = len(settings) if is_near else min(2 * count, enough)


class _Fit:
    """corrections: (s, 3 n) at settings (s, k), of which the first k move one slider each to its first place."""

    def __init__(self, knots, settings, corrections, may_join):
        self._knots = knots
        self._settings = settings
        self._corrections = corrections
        self._may_join = may_join
        self._seen = set()
        self._candidates = {}  # orders: (s,) weights
        for first in self._next_to(()):
            self._look_beside(first)
        self._look_beside(())

    def grown(self, goal, most):
        """(orders of at most so many polynomials, (m, 3 n) their shapes, error), with no more than the goal needs."""
        taken, basis = self._by_what_they_explain(most)

        def error(count):
            left = self._corrections - basis[:count].T @ (basis[:count] @ self._corrections)
            return _height(left)

        count = bisect.bisect_left(range(len(taken)), True, key=lambda number: error(number) <= goal)
        least = error(count)
        if error(0) <= least:  # what is no smooth motion
            count, least = 0, error(0)
        shapes = np.linalg.pinv(_weights(self._knots, taken[:count], self._settings)) @ self._corrections
        return taken[:count], shapes, least

    def _by_what_they_explain(self, most):
        """(orders of so many polynomials at most, (m, s) their weights made orthonormal), the best first."""
        gram = self._corrections @ self._corrections.T
        taken, basis = [], np.empty((0, len(gram)))
        while len(taken) < most and self._candidates:
            weights = np.array(list(self._candidates.values()))
            beside = weights - (weights @ basis.T) @ basis
            beside -= (beside @ basis.T) @ basis  # once more, for rounding
            lengths = np.linalg.norm(beside, axis=1)
            lengths[lengths <= INDEPENDENT * np.linalg.norm(weights, axis=1)] = np.inf
            beside /= lengths[:, None]
            explained = np.einsum("is,st,it->i", beside, gram, beside, optimize=True)
            best = int(explained.argmax())
            if explained[best] <= 0.0:
                break
            taken.append(list(self._candidates)[best])
            basis = np.concatenate([basis, beside[best, None]])
            del self._candidates[taken[-1]]
            self._look_beside(taken[-1])
        return taken, basis

    def _look_beside(self, orders):
        """Makes candidates of the polynomials next to `orders`."""
        for new in self._next_to(orders):
            if new in self._seen:
                continue
            self._seen.add(new)
            (slider, number), *others = new
            # Where a slider alone needs no correction at its first place, none is to be made there.
            if others or number > 1 or self._corrections[slider].any():
                self._candidates[new] = polynomials.weight(self._knots, new, self._settings)

    def _next_to(self, orders):
        orders = dict(orders)
        for slider in range(len(self._knots)) if len(orders) < MOST_SLIDERS else orders:
            number = orders.get(slider, 0) + 1
            is_apart = number == 1 and not all(self._may_join(slider, other) for other in orders)
            if is_apart or number == polynomials.MOST:
                continue
            new = tuple(sorted({**orders, slider: number}.items()))
            if polynomials.fits(self._knots, new):
                yield new


def _weights(knots, orders, settings):
    """(s, m)."""
    weights = [polynomials.weight(knots, each, settings) for each in orders]
    return np.array(weights).reshape(len(orders), len(settings)).T


def _setting(ranges, knots, number):
    """(k,): each slider alone at its first place, then points of a Kronecker sequence, which fill the box evenly.

    They crowd towards its ends, as polynomials need it, and some lie on them, where sliders are most of the time.
    """
    values = np.zeros(len(ranges))
    if number < len(ranges):
        values[number] = knots[number][1]
        return values
    roots = np.sqrt(list(itertools.islice(_primes(), len(ranges))))
    shares = (0.5 + (number - len(ranges) + 1) * roots) % 1.0
    low, high = np.array(ranges, np.float64).T
    return low + np.clip(0.5 - 0.55 * np.cos(np.pi * shares), 0.0, 1.0) * (high - low)


def _primes():
    for number in itertools.count(2):
        if all(number % other for other in range(2, int(number**0.5) + 1)):
            yield number


def _height(rows):
    """The longest of all vectors in rows (s, 3 n)."""
    vectors = rows.reshape(-1, 3)
    return float(np.sqrt(np.einsum("ij,ij->i", vectors, vectors).max(initial=0.0)))
