# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices named on the command line: by index, or by where they are. No bpy."""

from dataclasses import dataclass

import numpy as np

from .errors import DemoError

SYNTAX = (
    "12,40,7 (vertex indices) or near:X,Y,Z (the nearest vertex) or near:X,Y,Z,RADIUS (all in a ball) or "
    "part:X,Y,Z,RADIUS (those of the ball that hang together with its nearest vertex)"
)
VALUE_COUNTS = {"near": (3, 4), "part": (4,)}


@dataclass(frozen=True)
class Selection:
    """Either indices, or a centre (3,) with a radius; radius 0 stands for the nearest vertex.

    is_part: only the connected part of the ball that the nearest vertex belongs to.
    """

    text: str
    indices: tuple = ()
    centre: tuple = ()
    radius: float = 0.0
    is_part: bool = False


def parse_selection(text):
    """A Selection from SYNTAX. @throws ValueError."""
    kind, colon, words = text.partition(":")
    try:
        if not colon:
            return Selection(text, indices=tuple(int(word) for word in text.split(",")))
        values = [float(word) for word in words.split(",")]
    except ValueError:
        values = []
    if len(values) not in VALUE_COUNTS.get(kind, ()) or not np.all(np.isfinite(values)):
        raise ValueError(f"'{text}' is not a selection of vertices; write {SYNTAX}")
    radius = values[3] if len(values) == 4 else 0.0
    return Selection(text, centre=tuple(values[:3]), radius=radius, is_part=kind == "part")


def is_selection(text):
    """Whether `text` follows SYNTAX."""
    try:
        parse_selection(text)
    except ValueError:
        return False
    return True


def select(selection, positions, edges):
    """Ascending indices into `positions` (n, 3), of a mesh with `edges` (e, 2).

    @throws DemoError when there are none or they do not exist.
    """
    if selection.indices:
        chosen = np.unique(selection.indices)
        if chosen[0] < 0 or chosen[-1] >= len(positions):
            raise DemoError(f"'{selection.text}': vertex indices go from 0 to {len(positions) - 1} in this mesh")
        return chosen
    distance = np.linalg.norm(positions - np.array(selection.centre), axis=1)
    if selection.radius == 0.0:
        return np.array([np.argmin(distance)])
    chosen = np.flatnonzero(distance <= selection.radius)
    if len(chosen) == 0:
        low, high = positions.min(axis=0), positions.max(axis=0)
        raise DemoError(
            f"'{selection.text}' holds no vertex; the nearest is {distance.min():.4g} away. "
            f"The mesh reaches from {rounded(low)} to {rounded(high)}"
        )
    return connected_part(chosen, np.argmin(distance), edges, len(positions)) if selection.is_part else chosen


def connected_part(members, start, edges, vertex_count):
    """Ascending those of `members` that `start` reaches along edges between members."""
    inside = np.zeros(vertex_count, dtype=bool)
    inside[members] = True
    edges = edges[inside[edges].all(axis=1)]
    reached = np.zeros(vertex_count, dtype=bool)
    reached[start] = True
    while True:
        ends = reached[edges]
        border = edges[ends[:, 0] != ends[:, 1]]
        if len(border) == 0:
            return np.flatnonzero(reached)
        reached[border] = True


def rounded(point):
    """A point as text with four digits."""
    return "(" + ", ".join(f"{value:.4g}" for value in point) + ")"
