# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion for characters of other proportions: the directions of the capture with the lengths of the character."""

import numpy as np

from ...errors import InvalidMotionError
from ...scene.core.motion import turns_between
from . import landmarks as places
from .matching import marker_graph
from .proportions import carried, hips_of, with_hips

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
    """(f, m, 3) without NaN: a missing marker is where the first of its cells that is seen would carry it.

    turns  (f, c, 3, 3), of `MarkerGraph.rotations()`. What no cell tells is where the whole body would carry it; in a
    frame without any marker, everything is as in the reference.
    """
    result = markers.copy()
    for cell, (members, weights) in enumerate(zip(graph.members, graph.weights, strict=True)):
        _fill(result, markers, reference, members[weights > 0.0], turns[:, cell], least=2)
    everything = np.arange(markers.shape[1])
    _fill(result, markers, reference, everything, turns.mean(axis=1), least=1)
    return np.where(np.isnan(result), reference, result)


def _fill(result, markers, reference, members, turns, least):
    """Where at least so many of the members are seen, the others are where their rigid motion has them."""
    is_told = (~np.isnan(markers[:, members, 0])).sum(axis=1) >= least
    frames = np.flatnonzero(is_told & np.isnan(result[:, members, 0]).any(axis=1))
    moved = carried(reference[members], markers[frames][:, members], turns[frames])
    part = result[frames[:, None], members]
    result[frames[:, None], members] = np.where(np.isnan(part), moved, part)


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
