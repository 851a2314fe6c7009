# SPDX-License-Identifier: GPL-3.0-or-later
"""The shapes that are mixed (MixInput), and those that stand for a mix, each with a polynomial of sliders as weight.

Each is what the mix lacks at the place of its polynomial beside all lower ones, so the mix is met at all these places
(a sparse grid: Chkifa, Cohen, Schwab 2014). What lacks most comes first, until settings that have no say are met.

Polynomial `number` along a slider is 1 at the place of that number and 0 at the places before it. The places are a Leja
sequence: each is where the product of the distances to those before is largest, which keeps the polynomials small
between them (De Marchi, On Leja sequences, 2004). A product is named by its `orders`, ascending
((slider, number), ...). `knots` are the places() of all sliders.
"""

import collections
import functools
import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...scene.core import point_sets, whole_mesh
from ...scene.core.key_shapes import KeyShapes
from ...solver.core.fingerprint import digest


@dataclass(frozen=True, eq=False)
class MixInput(KeyShapes):
    """The KeyShapes of k sliders, all relative to the rest shape, and what of the mesh goes to the solver: triangles,
    m x 3 int32, of `whole`."""

    triangles: np.ndarray = None
    whole: whole_mesh.WholeMesh = None

    @cached_property
    def key(self):
        """Digest of all that a native Morpher of these shapes depends on."""
        shapes = (self.points[name] for name in self.names)
        whole = () if self.whole is None else (self.whole.rest, self.whole.places)
        return digest(self.rest, *shapes, self.triangles, *whole)

    @cached_property
    def revision(self):
        """Digest of all that a mix depends on but the sliders' values."""
        return digest(self.key, repr(self.sliders), *self.masks.values())

    @cached_property
    def diagonal(self):
        """Of the rest shape's bounding box."""
        return point_sets.bounding_box_diagonal(self.rest)

    def weights(self, values):
        """(k + 1,) or, where a shape counts here more than there, (k + 1, n) float64, the rest shape first: they sum to
        1 at each vertex. values: (k,) of the sliders."""
        counts = np.asarray(values, np.float64)
        if self.masks:
            is_needed = counts[self._is_part].any()
            counts = counts[:, None] * self._counts if is_needed else counts * self._counts[:, 0]
        return np.concatenate([[1.0 - counts.sum(axis=0)], counts])

    @cached_property
    def parts(self):
        """Numbers of the shapes, as of weights(), that do not count alike at all vertices; int32."""
        return 1 + np.flatnonzero(self._is_part).astype(np.int32)

    @cached_property
    def _is_part(self):
        if not self.masks:
            return np.zeros(len(self.sliders), bool)
        return (self._counts != self._counts[:, :1]).any(axis=1)

    @cached_property
    def _counts(self):
        """k x n float64: how much each shape counts at each vertex."""
        full = np.ones(len(self.rest))
        return np.array([self.masks.get(slider.group, full) for slider in self.sliders])

    def common(self, sliders):
        """How far all of some sliders (numbers) move one and the same vertex at least."""
        return float(self._moves[list(sliders)].min(axis=0).max(initial=0.0))

    @cached_property
    def _moves(self):
        """(k, n) float32: how far the sliders at 1 move the vertices."""
        return np.array([np.linalg.norm(self.points[name] - self.rest, axis=1) for name in self.names])


#: Settings that the shapes are judged by.
JUDGING = 64

#: Shapes are enough where no such setting is farther off than this share of the tolerance: elsewhere it may be more.
ENOUGH = 0.5

#: Sliders that are at work in one shape.
MOST_SLIDERS = 3

#: What lacks less than this share of the tolerance gets no shape, nor is anything next to it looked at.
SMALL = 0.05

#: So many times as many shapes as may be made are looked at with each further order.
LOOKED_AT = 8


#: orders: as above; offset: n x 3 float64 that is added with this weight.
InBetween = collections.namedtuple("InBetween", "orders offset")

#: shapes: tuple of InBetween; error: the largest distance of a vertex from the mix, at the settings judged by.
Found = collections.namedtuple("Found", "shapes error")


def found(solve, ranges, tolerance, most, common):
    """Steps to a Found. solve(values): steps to the correction, (n, 3), at slider settings (k,); at 0 it is 0.

    ranges: [(low, high)] of the sliders; tolerance: a distance; most: shapes at most; common(sliders): how far all of
    these sliders move one and the same vertex: where it is 0, they do not change each other's effect.
    """
    knots = [places(*each) for each in ranges]
    settings = np.array([setting(ranges, number) for number in range(JUDGING)])
    left = []  # what the mix lacks there
    for values in settings:
        left.append((yield from solve(values)))
    left = np.array(left)
    straight, shapes, last = _height(left), [], {(): np.inf}

    def lacking(orders):
        values = np.zeros(len(knots))
        for slider, number in orders:
            values[slider] = knots[slider][number]
        offset = yield from solve(values)
        for each in shapes:
            offset = offset - weight(knots, each.orders, values[None])[0] * each.offset
        return offset

    def is_enough():
        return len(shapes) == most or _height(left) <= ENOUGH * tolerance

    while last and not is_enough():
        bounds, heights = {}, {}  # of orders one higher in one slider than some of the last: what they lack at most
        for orders, height in last.items():
            higher = dict(orders)
            for slider in range(len(knots)) if len(higher) < MOST_SLIDERS else higher:
                number = higher.get(slider, 0) + 1
                new = tuple(sorted({**higher, slider: number}.items()))
                bound = min(height, common([each for each, _ in new]))
                together = sum(each for _, each in new)
                if bound > 0.0 and number < MOST and together <= MOST_TOGETHER:
                    bounds[new] = max(bound, bounds.get(new, 0.0))
        for orders in sorted(bounds, key=bounds.get, reverse=True)[: LOOKED_AT * most]:
            heights[orders] = _height((yield from lacking(orders)))
        for orders in sorted(heights, key=heights.get, reverse=True):
            if is_enough() or heights[orders] <= SMALL * tolerance:
                break
            shapes.append(InBetween(orders, (yield from lacking(orders))))  # solved anew: there may be many
            left -= weight(knots, orders, settings)[:, None, None] * shapes[-1].offset
        # A slider alone is right at its first place, which says nothing of the others.
        last = bounds if () in last else {each: high for each, high in heights.items() if high > SMALL * tolerance}
    error = _height(left)
    return Found(tuple(shapes), error) if error < straight else Found((), straight)


def setting(ranges, number):
    """(k,): a point of a Kronecker sequence, which fills the box. They crowd at its ends, as polynomials need it."""
    roots = 2.0 ** (np.arange(1, len(ranges) + 1) / (len(ranges) + 1))
    shares = (0.5 + (number + 1) * roots) % 1.0
    low, high = np.array(ranges, np.float64).T
    return low + np.clip(0.5 - 0.55 * np.cos(np.pi * shares), 0.0, 1.0) * (high - low)


def _height(vectors):
    """The longest of all vectors (..., 3)."""
    return float(np.sqrt(np.einsum("...i,...i->...", vectors, vectors).max(initial=0.0)))


#: No slider needs more: a turn by 180 degrees is met to 1e-6 by half as many.
MOST = 12

#: Places are rounded to so many decimals of a slider's range, so that drivers are short and mean the same.
DECIMALS = 4

#: All numbers of a product are no more than this: Blender cuts an expression at 255 characters.
MOST_TOGETHER = 14

VARIABLES = "abcdefghijklmnopqrstuvwxyz"


@functools.cache
def places(low, high):
    """The first MOST places, float64: 0, then 1 (or the end that is nearer), the ends, and those between."""
    low, high = min(low, 0.0), max(high, 0.0)
    found = [0.0, float(np.clip(1.0, low, high)) or low]
    finer = max(0, math.ceil(-math.log10(high - low)))
    tried = np.round(np.linspace(low, high, 2001), DECIMALS + finer)
    while len(found) < MOST:
        product = np.prod(np.abs(tried[:, None] - np.array(found)), axis=1)
        found.append(float(tried[product.argmax()]))
    return np.array(found)


def weight(knots, orders, settings):
    """(s,): the product with the sliders at each of `settings`, (s, k)."""
    result = np.ones(len(settings))
    for slider, number in orders:
        before = knots[slider][:number]
        result *= np.prod((settings[:, slider, None] - before) / (knots[slider][number] - before), axis=1)
    return result


def expression(knots, orders):
    """(text of a driver, of products alone, which need no Python; [number of the slider of each of its variables])."""
    scale, product = 1.0, []
    for variable, (slider, number) in zip(VARIABLES, orders, strict=False):
        before = knots[slider][:number]
        scale /= float(np.prod(knots[slider][number] - before))
        product += [variable if each == 0.0 else f"({variable}{-each:+.{DECIMALS + 2}g})" for each in before]
    return "*".join([f"{scale:.9g}", *product]), [slider for slider, _ in orders]


def label(names, knots, orders):
    """What a key is called: "Bend 0.5", "Bend 0.5 + Twist 1"."""
    return " + ".join(f"{names[slider]} {knots[slider][number]:.3g}" for slider, number in orders)
