# SPDX-License-Identifier: GPL-3.0-or-later
"""From a take and a mesh to the handles that carry it: mended, aligned, matched, and where each vertex goes.

All of it is in the space of the world, where lengths mean something and there is an up; only what is written for the
object is in its own. Nothing here touches Blender.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import fixed_points, motion
from ...scene.core.surface import Surface
from ...solver.core.steps import result_of
from ..core import alignment, filtering, gaps, landmarks, marker_sets, matching, retargeting, skin
from ..core.limb_posing import posed_and_actor
from . import marker_cuffs, match_notes, mended_takes

#: Fewer points leave open how the markers are turned.
LEAST_PAIRS = 3

#: A handle that is let go at once would have its skin jump.
RAMP_SECONDS = 0.08

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
    cuffs      [marker_cuffs.CuffMotion]; told_of_cuffs  sentences
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
    filled: dict = field(default_factory=dict)
    cuffs: list = field(default_factory=list)
    told_of_cuffs: list = field(default_factory=list)
    notes: list = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Markers:
    """A mended take: m labels and their landmarks (or None), path (f, m, 3), how (f, m) as gaps.fill_gaps() tells,
    reference (m, 3), and actor (m, 3): the same with the lengths of the one who was captured, or None: these it has."""

    labels: list
    landmarks: tuple
    path: np.ndarray
    how: np.ndarray
    reference: np.ndarray
    actor: np.ndarray | None = None


def find(given, only=None):
    """The Matched of a bridge.match_input.MatchInput. @throws MeanValueError."""
    return result_of(steps(given, only))


def steps(given, only=None):
    """Generator of (stage, share that is done) that returns the Matched. @throws MeanValueError.

    only  the one marker whose targets are wanted, or None: all; those of others are NaN then.
    """
    recording, standing = given.recording, given.standing
    path, how = yield from mended_takes.steps(recording, _longest(given, recording), given.cutoff_hz)
    sample = standing.sample_at(given.reference_frame)
    frame = float(standing.frames[sample])
    markers, notes = _chosen(given, frame, path, how, _reference(given, path, sample))
    notes += [*match_notes.of_frame(given, frame), *match_notes.of_retargeting(given, markers)]
    yield "aligning", 0.3
    to_mesh, words = _alignment(given, markers)
    aligned = replace(
        markers, path=motion.apply(to_mesh, markers.path), reference=motion.apply(to_mesh, markers.reference)
    )
    if given.pose_limbs:
        yield "posing limbs", 0.4
        surface = given.surface
        posed, actor = posed_and_actor(aligned.reference, aligned.landmarks, surface.vertices, surface.triangles)
        aligned = replace(aligned, reference=posed, actor=actor)
    laid = aligned.reference
    yield "matching", 0.5
    match = _match(given, aligned)
    if given.mode == 'RETARGET':
        yield "retargeting", 0.6
        aligned, match = _retargeted(given, aligned, match)
    yield "following the skin", 0.7
    targets = _targets(aligned, match, only)
    yield "laying cuffs", 0.8
    laid_cuffs, told = marker_cuffs.find(given, aligned, match) if only is None else ([], [])
    yield "making handles", 0.9
    markers = replace(markers, reference=laid)
    matched = _matched(given, markers, to_mesh, match, targets, frame, [*given.notes, *notes, *words])
    return replace(matched, cuffs=laid_cuffs, told_of_cuffs=told)


def _targets(aligned, match, only):
    if only is None:
        return skin.skin_targets(aligned.path, aligned.reference, match, aligned.landmarks)
    rows = [row for row, label in enumerate(aligned.labels) if label == only]
    targets = np.full_like(aligned.path, np.nan)
    targets[:, rows] = skin.skin_targets(aligned.path, aligned.reference, match, aligned.landmarks, rows)
    return targets


def _longest(given, recording):
    """The longest gaps to be filled by splines and by neighbours, in samples."""
    return tuple(int(seconds * recording.rate_hz + 1e-6) for seconds in (given.spline_seconds, given.rigid_seconds))


def _reference(given, path, sample):
    """(m, 3): where the markers of the take are at the reference; NaN for what is not seen there."""
    standing = given.standing
    if standing is given.recording:
        return path[sample]
    mended, _ = gaps.fill_gaps(standing.positions, *_longest(given, standing))
    if given.cutoff_hz is not None:
        mended = filtering.low_pass(mended, standing.rate_hz, given.cutoff_hz)
    places = dict(zip(standing.labels, mended[sample], strict=True))
    return np.array([places.get(label, np.full(3, np.nan)) for label in given.recording.labels])


def _chosen(given, frame, path, how, reference):
    """(the Markers that are used and seen in the reference, notes). @throws SceneError if there is none."""
    used = [number for number, label in enumerate(given.recording.labels) if label in given.used]
    seen = [number for number in used if not np.isnan(reference[number]).any()]
    where = f"frame {frame:g} of '{given.reference_name}'"
    if not used:
        raise SceneError("No marker is ticked in the list. Tick those that should move the mesh")
    if not seen:
        raise SceneError(f"No marker is seen in {where}. Choose another Reference Frame")
    placeless = []
    if landmarks.has_joints(given.landmarks.values()):
        placeless = [label for label in map(given.recording.labels.__getitem__, seen) if not _has_place(given, label)]
        seen = [number for number in seen if given.recording.labels[number] not in placeless]
    labels = [given.recording.labels[number] for number in seen]
    unseen = [label for label in (given.recording.labels[k] for k in used) if label not in {*labels, *placeless}]
    notes = []
    if placeless:
        notes.append(
            f"{wording.counted(len(placeless), 'joint')} of the skeleton, {wording.quoted(placeless)}, "
            f"{'has' if len(placeless) == 1 else 'have'} no known place on the body and got no handle: they would pull "
            "at skin that is not theirs. Choose a Landmark, or pick the point, of those that should have one"
        )
    if unseen:
        notes.append(
            f"{wording.quoted(unseen)} {'is' if len(unseen) == 1 else 'are'} not seen in {where} and got no handle. "
            "Choose a frame that has them, or fill longer gaps"
        )
    known = tuple(given.landmarks[label] for label in labels)
    return Markers(labels, known, path[:, seen], how[:, seen], reference[seen]), notes


def _has_place(given, label):
    return given.landmarks[label] or label in given.fixed


def _alignment(given, markers):
    """(4 x 4 from the markers' world to where they lie on the mesh, in the world; notes). @throws MeanValueError."""
    surface = given.surface
    if given.to_object is not None:
        return surface.to_world @ given.to_object, []
    if given.align == 'NONE':
        return np.eye(4), []
    if given.align == 'AUTO':
        known = {label: place for label, place in zip(markers.labels, markers.landmarks, strict=True) if place}
        sets = [marker_sets.MarkerSet("as chosen", known)] if known else []
        found = alignment.align_to_mesh(
            markers.reference, markers.labels, surface.vertices, surface.triangles, more_sets=sets
        )
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


def _match(given, markers):
    """The matching.Match of the aligned markers; what is fixed has its vertex, and no other has that."""
    surface, labels, reference = given.surface, markers.labels, markers.reference
    match = matching.match_to_surface(reference, surface.vertices, surface.triangles)
    vertex, distance = match.vertex.copy(), match.distance.copy()
    is_fixed = np.array([label in given.fixed for label in labels])
    if is_fixed.any():
        vertex[is_fixed] = [given.fixed[label] for label in labels if label in given.fixed]
        distance[is_fixed] = np.linalg.norm(reference - surface.vertices[vertex], axis=1)[is_fixed]
        left = np.setdiff1d(np.unique(surface.triangles), list(given.fixed.values()))
        if len(left) < np.count_nonzero(~is_fixed):
            raise SceneError("The mesh has less vertices than there are markers, and each needs its own. Subdivide it")
        if not is_fixed.all():
            vertex[~is_fixed] = left[matching.one_to_one(match.point[~is_fixed], surface.vertices[left])]
    return _with_markers_at(replace(match, vertex=vertex, distance=distance), surface, reference)


def _with_markers_at(match, surface, places):
    """The Match with offsets as if the markers were at `places` (m, 3)."""
    offset = np.einsum("mji,mj->mi", match.frame, places - surface.vertices[match.vertex])
    return replace(match, offset=offset)


def _retargeted(given, markers, match):
    """(Markers, Match) with the lengths of the character.

    On it the markers are where they were aligned, but those whose points were picked by hand are over these, as far off
    the skin as the others usually are.
    """
    surface = given.surface
    picked = np.array([label in given.picked for label in markers.labels])
    usual = float(np.median(match.distance[~picked])) if (~picked).any() else 0.0
    normals = Surface(surface.vertices, surface.triangles).normals()[match.vertex]
    character = np.where(picked[:, None], surface.vertices[match.vertex] + usual * normals, markers.reference)
    rate = given.recording.rate_hz
    actor = markers.reference if markers.actor is None else markers.actor
    path = retargeting.retarget(markers.path, actor, character, rate, markers.landmarks)
    return replace(markers, path=path, reference=character), _with_markers_at(match, surface, character)


def _matched(given, markers, to_mesh, match, targets, frame, notes):
    """markers: with the reference as it was laid on the mesh, in the world."""
    to_object = np.linalg.inv(given.surface.to_world)
    rest = given.surface.own[match.vertex].astype(np.float64)
    return Matched(
        names=markers.labels,
        vertices=match.vertex,
        rest=rest,
        offsets=motion.apply(to_object, markers.reference) - rest,
        distance=match.distance,
        targets=motion.apply(to_object, targets),
        frames=given.recording.frames,
        frame=frame,
        alignment=to_object @ to_mesh,
        size=fixed_points.bounding_box_diagonal(given.surface.own),
        recognition=given.recognition,
        world_size=fixed_points.bounding_box_diagonal(given.surface.vertices),
        ramp=round(RAMP_SECONDS * given.recording.rate_hz),
        filled=_filled(markers.how),
        notes=notes,
    )


def _filled(how):
    words = {gaps.SPLINE: "filled by splines", gaps.RIGID: "filled by neighbors", gaps.MISSING: "left free"}
    return {text: float(np.mean(how == kind)) for kind, text in words.items()}
