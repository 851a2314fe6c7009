# SPDX-License-Identifier: GPL-3.0-or-later
"""Each marker's place on the mesh: a vertex of its own, where the marker is from it, and where its skin goes; and
motion for characters of other proportions, by the same cells: the directions of the capture with their lengths."""

import collections
import itertools
from dataclasses import dataclass

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core.motion import fit_rotations, nearest_rotations, turns_between
from ...scene.core.point_sets import parts
from . import landmarks as places
from .gaps import distance_variation
from .proportions import carried, hips_of, with_hips

#: Of each of m markers: (m,) the anchor vertex, another one for each; (m, 3) from that to the marker, at rest; (m,) its
#: distance from the surface, or from a vertex that was given.
Match = collections.namedtuple("Match", "vertex offset distance")


def match_to_surface(markers, surface, fixed=None):
    """The `Match` of markers (m, 3), aligned, with the Surface nearest to them.

    Anchor vertices are those nearest to the surface points. Where markers compete for one, the first has it, and the
    next takes the nearest that is left. fixed  {marker number: vertex} that are given.
    Raises InvalidMotionError for meshes with less used vertices than markers.
    """
    fixed = fixed or {}
    unknown = [number for number in range(len(markers)) if number not in fixed]
    free = np.setdiff1d(surface.triangles, list(fixed.values()))
    if len(free) < len(unknown):
        raise InvalidMotionError(
            f"The mesh has {len(free)} vertices for {len(unknown)} markers, and each needs one of its own: subdivide it"
        )
    vertex = np.array([fixed.get(number, -1) for number in range(len(markers))])
    _, _, points, distance = surface.nearest(markers)
    for number in unknown:
        nearest = ((surface.vertices[free] - points[number]) ** 2).sum(axis=1).argmin()
        vertex[number] = free[nearest]
        free = np.delete(free, nearest)
    offset = markers - surface.vertices[vertex]
    given = list(fixed)
    distance[given] = np.linalg.norm(offset[given], axis=1)
    return Match(vertex, offset, distance)


def skin_targets(markers, reference, offsets, landmarks):
    """(f, m, 3): where the anchor vertices go. Each marker minus its offset from the skin, turned with the surface.

    The surface at a marker turns from the reference to a frame as the segments of the body do that the marker is of,
    else as the markers around it (Kabsch 1976). What the others leave open (one neighbor, all on a line) turns as the
    whole body does.

    markers  (f, m, 3) in the mesh's space and size; NaN stay NaN. reference  (m, 3) the markers that were matched, as
    aligned. offsets  (m, 3), of Match. landmarks  m names or None.
    """
    # Thighs often have two markers: the hips, which go with the pelvis, tell how they turn.
    rest, moving, names = with_hips(reference, markers, landmarks)
    graph = marker_graph(rest, names, moving)
    turns = nearest_rotations(np.einsum("mc,fcij->fmij", graph.shares, graph.rotations(rest, moving)))
    turns = turns[:, : len(reference)]
    return markers - np.einsum("fmij,mj->fmi", turns, offsets)


#: Markers that make a cell with one whose place on the body is unknown.
NEAREST = 5
#: A marker counts as farther by this many times the standard deviation of its distance.
TOGETHER = 20.0
#: Rows of frames that are worked on at once: some megabytes.
CHUNK = 512


@dataclass(frozen=True, eq=False)
class MarkerGraph:
    """c cells of at most k of m markers, and e edges."""

    members: np.ndarray  # (c, k) marker numbers. A smaller cell is filled up with its first one, at weight 0
    weights: np.ndarray  # (c, k) 1 or 0
    shares: np.ndarray  # (m, c) how much each marker turns with each cell; rows sum to 1
    edges: np.ndarray  # (e, 2) marker numbers, and (e,) the cell that an edge turns with
    cell_of_edge: np.ndarray

    def rotations(self, reference, markers):
        """(f, c, 3, 3): turn of each cell from the reference (m, 3) to each frame of markers (f, m, 3).

        NaN do not count; what a cell leaves open turns as the whole body does.
        """
        body = fit_rotations(reference, markers)
        result = np.empty((len(markers), len(self.members), 3, 3))
        for begin in range(0, len(markers), CHUNK):
            rows = slice(begin, begin + CHUNK)
            result[rows] = fit_rotations(
                reference[self.members], markers[rows][:, self.members], self.weights, body[rows, None]
            )
        return result


def marker_graph(reference, landmarks, markers):
    """The MarkerGraph whose cells are the segments of the body (landmarks.py). A marker that is in none gets a cell of
    its own, with the NEAREST markers that move with it.

    reference  (m, 3); landmarks  m names or None; markers  (f, m, 3), which tell what moves together.
    """
    near = np.linalg.norm(reference[:, None] - reference[None], axis=2)
    variation = distance_variation(markers)
    distances = near + TOGETHER * np.where(np.isfinite(variation), variation, near)
    np.fill_diagonal(distances, 0.0)
    cells = [numbers for _, numbers in sorted(places.segments(landmarks).items())]
    cells_of = [[cell for cell, numbers in enumerate(cells) if number in numbers] for number in range(len(reference))]
    for number, own in enumerate(cells_of):
        if not own:
            own.append(len(cells))
            cells.append(np.argsort(distances[number], kind="stable")[: NEAREST + 1].tolist())
    owners = {}
    for cell, numbers in enumerate(cells):
        for pair in itertools.combinations(numbers, 2):
            owners.setdefault(tuple(sorted(pair)), cell)
    _join(owners, cells_of, near)
    widest = max(map(len, cells))
    return MarkerGraph(
        members=np.array([numbers + numbers[:1] * (widest - len(numbers)) for numbers in cells]),
        weights=np.array([[1.0] * len(numbers) + [0.0] * (widest - len(numbers)) for numbers in cells]),
        shares=np.array([[(cell in own) / len(own) for cell in range(len(cells))] for own in cells_of]),
        edges=np.array(list(owners), int).reshape(-1, 2),
        cell_of_edge=np.array(list(owners.values()), int),
    )


def _join(owners, cells_of, distances):
    """Adds the shortest edges that join all markers into one graph. owners: {edge: its cell}."""
    while (part := parts(np.array(list(owners), int).reshape(-1, 2), len(distances))).any():
        apart = np.where(part[:, None] != part[None], distances, np.inf)
        first, second = (int(k) for k in np.unravel_index(np.argmin(apart), apart.shape))
        owners[min(first, second), max(first, second)] = cells_of[first][0]


#: Degrees between the ways that reference and character look.
MOST_TURNED = 60.0


def retarget(markers, reference, character, landmarks):
    """(f, m, 3) float64: where the markers would go on a character of other proportions.

    Edges between neighboring markers (of one segment of the body) turn as in the capture, and have the character's
    length, times what the capture itself stretches them by. The markers that fit these edges best are one linear solve,
    the same for all frames: as-rigid-as-possible (Sorkine and Alexa 2007) with rotations given by the capture.
    The pelvis goes the captured way, scaled by its height in character and reference; soles.py has feet stand.

    markers  (f, m, 3) meters, Z up: what is NaN stays NaN, and is taken to move with its segment meanwhile.
    reference  (m, 3): the body upright, in any pose; character  (m, 3): the same markers on the character in about that
    pose, looking the same way. landmarks  m names or None; markers without one are joined with their nearest ones.
    Raises InvalidMotionError for less than three markers, and where the character looks another way.
    """
    count = markers.shape[1]
    if count < 3:
        raise InvalidMotionError(f"A body needs at least 3 markers to be retargeted, but there are {count}.")
    flat = [points[:, :2] - points[:, :2].mean(axis=0) for points in (reference, character)]
    cosine, sine = (flat[0] * flat[1]).sum(), (flat[0][:, 0] * flat[1][:, 1] - flat[0][:, 1] * flat[1][:, 0]).sum()
    angle = np.degrees(np.arctan2(sine, cosine))
    if abs(angle) > MOST_TURNED and np.hypot(cosine, sine) > 0.0:
        raise InvalidMotionError(
            f"The character's markers are turned by {angle:.0f} degrees from those of the reference frame: "
            "align the capture with the character first, or check that left and right are not exchanged."
        )
    reference, completed, landmarks = with_hips(reference, markers, landmarks)
    if len(reference) > count:
        hips, own = (hips_of(points, landmarks[:count]) for points in (character, reference[:count]))
        size = np.linalg.norm(hips[0] - hips[1]) / max(np.linalg.norm(own[0] - own[1]), 1e-12)
        character = np.concatenate([character, hips + size * (reference[count:] - own)])
    graph = marker_graph(reference, landmarks, completed)
    turns = graph.rotations(reference, completed)
    completed = complete(completed, reference, graph, turns)
    shape = _solved(graph, turns, completed, reference, character)
    root = [k for k, landmark in enumerate(landmarks) if "pelvis" in places.segments_of(landmark)]
    root = root or list(range(len(reference)))
    ground = [number for foot in places.feet(landmarks).values() for number in foot] or root
    heights = [points[root, 2].mean() - points[ground, 2].min() for points in (character, reference)]
    sizes = [np.linalg.norm(np.ptp(points, axis=0)) for points in (character, reference)]
    ratio = heights[0] / heights[1] if min(heights) > 0.1 * min(sizes) else sizes[0] / max(sizes[1], 1e-12)
    path = character[root].mean(axis=0) + ratio * (completed[:, root].mean(axis=1) - reference[root].mean(axis=0))
    result = (shape + (path - shape[:, root].mean(axis=1))[:, None])[:, :count]
    result[np.isnan(markers)] = np.nan
    return result


def complete(markers, reference, graph, turns):
    """(f, m, 3) without NaN: a missing marker is where the first of its cells that is seen would carry it, else the
    whole body; in a frame with one marker or none, all is as in the reference. turns: of `MarkerGraph.rotations()`.
    """
    result = markers.copy()
    cells = [members[weights > 0.0] for members, weights in zip(graph.members, graph.weights, strict=True)]
    everything = np.arange(markers.shape[1]), turns.mean(axis=1)
    for members, turned in (*zip(cells, turns.swapaxes(0, 1), strict=True), everything):
        moved = carried(reference[members], markers[:, members], turned)
        moved[(~np.isnan(markers[:, members, 0])).sum(axis=1) < 2] = np.nan  # one tells less than the whole body
        result[:, members] = np.where(np.isnan(result[:, members]), moved, result[:, members])
    return np.where(np.isnan(result), reference, result)


def _solved(graph, turns, markers, reference, character):
    """(f, m, 3): the markers that fit the character's edges best, each frame about its center."""
    first, second = graph.edges.T
    of_reference, of_character = reference[second] - reference[first], character[second] - character[first]
    rest_lengths = np.maximum(np.linalg.norm(of_reference, axis=1), 1e-9)
    least = 1e-3 * np.median(rest_lengths)
    lengths = np.linalg.norm(of_character, axis=1)
    weights = 1.0 / np.maximum(lengths, least) ** 2  # relative errors count
    incidence = np.eye(len(reference))[second] - np.eye(len(reference))[first]
    solve = np.linalg.pinv(incidence.T @ (weights[:, None] * incidence), rcond=1e-10) @ (incidence.T * weights)
    result = np.empty_like(markers)
    for begin in range(0, len(markers), 512):
        part = slice(begin, begin + 512)
        edges = markers[part][:, second] - markers[part][:, first]
        # Markers in one place of the reference tell of no stretching.
        stretch = np.where(rest_lengths > least, np.linalg.norm(edges, axis=2) / rest_lengths, 1.0)
        turned = turns[part][:, graph.cell_of_edge]
        carried = np.einsum("feij,ej->fei", turned, of_reference)
        wanted = np.einsum("feij,ej->fei", turned, of_character)
        wanted = np.einsum("feij,fej->fei", turns_between(carried, edges), wanted)
        result[part] = np.einsum("me,fej->fmj", solve, stretch[..., None] * wanted)
    return result
