# SPDX-License-Identifier: GPL-3.0-or-later
"""From a take and a mesh to the handles that carry it: mended, aligned, matched, and where each vertex goes.

All of it is in the space of the world, where lengths mean something and there is an up; only what is written for the
object is in its own. Nothing here touches Blender.
"""

from dataclasses import dataclass, replace

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import fixed_points, motion
from ...scene.core.surface import Surface
from ...solver.core.steps import result_of
from ..core import alignment, gaps, landmarks, matching, retargeting, skin
from ..core.limb_posing import posed_and_actor
from . import marker_cuffs, match_notes, mended_takes

#: Fewer points leave open how the markers are turned.
LEAST_PAIRS = 3

#: A handle that is let go at once would have its skin jump.
RAMP_SECONDS = 0.08

FILLED = {gaps.SPLINE: "filled by splines", gaps.RIGID: "filled by neighbors", gaps.MISSING: "left free"}

#: Of an automatic alignment (core.capture.alignment.Alignment): from where on the artist is told to look at it.
DOUBTFUL, POOR = 1.1, 0.03


@dataclass(frozen=True, eq=False)
class Matched:
    """What was found for m markers.

    names      of the markers
    vertices   (m,) distinct vertex indices
    rest       (m, 3) where these are at rest, in the object's space
    offsets    (m, 3) from there to the aligned marker at the reference frame, in the object's space
    distance   (m,) how far the marker is from its point, in the world
    targets    (f, m, 3) where the vertices go, in the object's space; NaN where nobody knows
    frames     (f,) of the scene
    frame      of the reference
    alignment  4 x 4, from where the markers are in the world to the object's space
    size       bounding-box diagonal of the mesh, in its own space
    world_size  the same in the world
    recognition  how the names of the markers were known, in words
    filled     {how, in words: share of the samples}
    ramp       samples over which a handle fades before and after a gap
    cuffs      of marker_cuffs.find(); told_of_cuffs  sentences
    """

    names: list
    vertices: np.ndarray
    rest: np.ndarray
    offsets: np.ndarray
    distance: np.ndarray
    targets: np.ndarray
    frames: np.ndarray
    frame: float
    alignment: np.ndarray
    size: float
    world_size: float
    recognition: str
    ramp: int
    filled: dict
    cuffs: list
    told_of_cuffs: list
    notes: list


@dataclass(frozen=True, eq=False)
class Markers:
    """A mended take: m labels and their landmarks (or None), path (f, m, 3), how (f, m) as gaps.fill_gaps() tells,
    reference (m, 3), and actor (m, 3): the same with the lengths of the one who was captured."""

    labels: list
    landmarks: tuple
    path: np.ndarray
    how: np.ndarray
    reference: np.ndarray
    actor: np.ndarray


def find(given):
    """The Matched of a bridge.match_input.MatchInput. @throws MeanValueError."""
    return result_of(steps(given))


def steps(given):
    """Generator of (stage, share that is done) that returns the Matched. @throws MeanValueError."""
    options, surface = given.options, given.surface
    yield "filling gaps", 0.0
    path, how = _mended(given, given.recording)
    sample = given.standing.sample_at(options.reference_frame)
    frame = float(given.standing.frames[sample])
    markers, notes = _chosen(given, frame, path, how, _reference(given, sample))
    notes += [*match_notes.of_frame(given, frame), *match_notes.of_retargeting(given, markers)]
    yield "aligning", 0.3
    to_mesh, words = _alignment(given, markers)
    laid = motion.apply(to_mesh, markers.reference)
    markers = replace(markers, path=motion.apply(to_mesh, markers.path), reference=laid, actor=laid)
    if options.pose_limbs and options.align != 'NONE':
        yield "posing limbs", 0.4
        laid, actor = posed_and_actor(laid, markers.landmarks, surface.vertices, surface.triangles)
        markers = replace(markers, reference=laid, actor=actor)
    yield "matching", 0.5
    fixed = {row: given.fixed[label] for row, label in enumerate(markers.labels) if label in given.fixed}
    match = matching.match_to_surface(laid, surface.vertices, surface.triangles, fixed)
    if options.mode == 'RETARGET':
        yield "retargeting", 0.6
        markers, match = _retargeted(given, markers, match)
    yield "following the skin", 0.7
    targets = skin.skin_targets(markers.path, markers.reference, match, markers.landmarks)
    yield "laying cuffs", 0.8
    cuffs, told_of_cuffs = marker_cuffs.find(given, markers, match)
    yield "making handles", 0.9
    to_object = np.linalg.inv(surface.to_world)
    rest = surface.own[match.vertex].astype(np.float64)
    return Matched(
        names=markers.labels,
        vertices=match.vertex,
        rest=rest,
        offsets=motion.apply(to_object, laid) - rest,
        distance=match.distance,
        targets=motion.apply(to_object, targets),
        frames=given.recording.frames,
        frame=frame,
        alignment=to_object @ to_mesh,
        size=fixed_points.bounding_box_diagonal(surface.own),
        recognition=given.recognition,
        world_size=fixed_points.bounding_box_diagonal(surface.vertices),
        ramp=round(RAMP_SECONDS * given.recording.rate_hz),
        filled={words: float(np.mean(markers.how == kind)) for kind, words in FILLED.items()},
        cuffs=cuffs,
        told_of_cuffs=told_of_cuffs,
        notes=[*given.notes, *notes, *words],
    )


def _mended(given, recording):
    longest = given.options.spline_seconds, given.options.rigid_seconds
    return mended_takes.mended(recording, longest, given.options.cutoff_hz)


def _reference(given, sample):
    """(m, 3): where the markers of the take are at the reference; NaN for what is not seen there."""
    path, _ = _mended(given, given.standing)
    places = dict(zip(given.standing.labels, path[sample], strict=True))
    return np.array([places.get(label, np.full(3, np.nan)) for label in given.recording.labels])


def _chosen(given, frame, path, how, reference):
    """(the Markers that are used and seen in the reference, notes). @throws SceneError if there is none."""
    labels = given.recording.labels
    used = [number for number, label in enumerate(labels) if label in given.used]
    seen = [number for number in used if not np.isnan(reference[number]).any()]
    unseen = [labels[number] for number in used if number not in seen]
    where = f"frame {frame:g} of '{given.reference_name}'"
    if not used:
        raise SceneError("No marker is ticked in the list. Tick those that should move the mesh")
    if not seen:
        raise SceneError(f"No marker is seen in {where}. Choose another Reference Frame")
    notes = []
    if landmarks.has_joints(given.landmarks.values()):
        placed = [number for number in seen if given.landmarks[labels[number]] or labels[number] in given.fixed]
        placeless = [labels[number] for number in seen if number not in placed]
        notes += match_notes.of_placeless(placeless)
        seen = placed
    if unseen:
        notes.append(
            f"Not seen in {where}, and without a handle: {wording.quoted(unseen)}. Choose a frame that has them, or "
            "fill longer gaps"
        )
    names = [labels[number] for number in seen]
    known = tuple(given.landmarks[name] for name in names)
    return Markers(names, known, path[:, seen], how[:, seen], reference[seen], reference[seen]), notes


def _alignment(given, markers):
    """(4 x 4 from the markers' world to where they lie on the mesh, in the world; notes). @throws MeanValueError."""
    surface = given.surface
    if given.to_object is not None:
        return surface.to_world @ given.to_object, []
    if given.options.align == 'NONE':
        return np.eye(4), []
    if given.options.align == 'AUTO':
        found = alignment.align_to_mesh(markers.reference, markers.landmarks, surface.vertices, surface.triangles)
        is_doubtful = found.certainty < DOUBTFUL or found.quality > POOR
        words = f"{found.words} If it is wrong, pick three points and align by these"
        return found.matrix, [*match_notes.of_limbs(markers), *([words] if is_doubtful else [])]
    rows = [row for row, label in enumerate(markers.labels) if label in given.fixed]
    targets = surface.vertices[[given.fixed[markers.labels[row]] for row in rows]]
    if len(rows) < LEAST_PAIRS or not fixed_points.span_a_plane(markers.reference[rows]):
        raise SceneError(
            f"Picked Pairs needs the points of at least {LEAST_PAIRS} markers that are not in one line, and "
            f"{wording.counted(len(rows), 'marker')} {'has' if len(rows) == 1 else 'have'} one. Choose a marker in the "
            "list, press Pick Point and click its point on the mesh"
        )
    return alignment.similarity(markers.reference[rows], targets), []


def _retargeted(given, markers, match):
    """(Markers, Match) with the lengths of the character.

    On it the markers are where they were aligned, but those whose points were picked by hand are over these, as far off
    the skin as the others usually are.
    """
    surface = given.surface
    picked = np.array([label in given.picked for label in markers.labels])
    usual = float(np.median(match.distance[~picked])) if (~picked).any() else 0.0
    normals = Surface(surface.vertices, surface.triangles).normals()[match.vertex]
    points = surface.vertices[match.vertex]
    character = np.where(picked[:, None], points + usual * normals, markers.reference)
    rate = given.recording.rate_hz
    path = retargeting.retarget(markers.path, markers.actor, character, rate, markers.landmarks)
    return replace(markers, path=path, reference=character), replace(match, offset=character - points)
