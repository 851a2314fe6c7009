# SPDX-License-Identifier: GPL-3.0-or-later
"""From a take and a mesh to the handles that carry it: mended, aligned, matched, and where each vertex goes.

All of it is in the space of the world, where lengths mean something and there is an up; only what is written for the
object is in its own.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from ..bridge import marker_pairs, marker_presets, mesh_arrays, shape_keys, takes
from ..core import fixed_points, wording
from ..core.capture import alignment, filtering, gaps, marker_sets, matching, retargeting, skin
from ..core.capture.surface import Surface
from ..errors import SceneError

#: Fewer points leave open how the markers are turned.
LEAST_PAIRS = 3

#: Of an automatic alignment (core.capture.alignment.Alignment): from where on the artist is told to look at it.
DOUBTFUL, POOR = 1.1, 0.03


@dataclass(frozen=True, eq=False)
class Matched:
    """What find() found for m markers.

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
    filled     {how, in words: share of the samples}
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
    filled: dict = field(default_factory=dict)
    notes: list = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class RestShape:
    """own: n x 3 in the object's space, vertices: n x 3 in the world; triangles t x 3; to_world 4 x 4."""

    own: np.ndarray
    vertices: np.ndarray
    triangles: np.ndarray
    to_world: np.ndarray


@dataclass(frozen=True, eq=False)
class Markers:
    """A mended take. path (f, m, 3), how (f, m) as gaps.fill_gaps(), reference (m, 3), frame: of the reference.

    landmarks: m names or None, once they are known.
    """

    rate_hz: float

    labels: tuple
    path: np.ndarray
    how: np.ndarray
    reference: np.ndarray
    frames: np.ndarray
    frame: float
    landmarks: tuple = ()


def find(obj, to_object=None, fixed=None, picked=None):
    """The Matched of a mesh object and its take. Changes nothing.

    to_object: 4 x 4 from the markers' world to the object's space, to be kept; None: as the settings say.
    fixed: {marker: vertex} to be kept, beside those that were picked; picked: {marker: vertex} that are picked now.
    @throws MeanValueError.
    """
    capture = obj.meanvalue.capture
    surface = _surface(obj)
    markers = _mended(capture)
    own = {pair.name: pair.vertex for pair in capture.pairs if pair.is_picked and pair.vertex >= 0}
    fixed = {**(fixed or {}), **own, **(picked or {})}
    picked = {**own, **(picked or {})}
    _require_vertices(obj, fixed)
    chosen, notes = _chosen(capture, markers)
    labels = [markers.labels[number] for number in chosen]
    landmarks, more = marker_presets.recognised(capture, labels)
    if to_object is None:
        to_mesh, words = _alignment(capture, surface, markers.reference[chosen], labels, landmarks, fixed)
        notes += [*more, *words]
    else:
        to_mesh = surface.to_world @ to_object
    aligned = replace(
        markers,
        labels=labels,
        path=_apply(to_mesh, markers.path[:, chosen]),
        how=markers.how[:, chosen],
        reference=_apply(to_mesh, markers.reference[chosen]),
        landmarks=landmarks,
    )
    match = _match(surface, labels, aligned.reference, fixed)
    targets = _targets(capture, surface, aligned, match, np.array([label in picked for label in labels]))
    to_object = np.linalg.inv(surface.to_world)
    rest = surface.own[match.vertex].astype(np.float64)
    return Matched(
        names=labels,
        vertices=match.vertex,
        rest=rest,
        offsets=_apply(to_object, aligned.reference) - rest,
        distance=match.distance,
        targets=_apply(to_object, targets),
        frames=markers.frames,
        frame=markers.frame,
        alignment=to_object @ to_mesh,
        size=fixed_points.bounding_box_diagonal(surface.own),
        filled=_filled(aligned.how),
        notes=notes,
    )


def find_again(obj, name, vertex):
    """As find(), with all as it was last matched but for the marker `name`, which gets `vertex`."""
    capture = obj.meanvalue.capture
    fixed = {pair.name: pair.vertex for pair in marker_pairs.matched(obj) if pair.vertex >= 0}
    return find(obj, np.array(capture.alignment, np.float64).reshape(4, 4), fixed, {name: vertex})


def _surface(obj):
    """@throws SceneError."""
    if len(obj.data.polygons) == 0:
        raise SceneError(f"'{obj.name}' has no faces, so no marker can be laid on it. Choose a mesh with a surface")
    to_world = np.array(obj.matrix_world, np.float64)
    if not np.linalg.cond(to_world[:3, :3]) < 1e9:
        raise SceneError(f"'{obj.name}' is scaled to nothing. Give it a size")
    own = shape_keys.rest_positions(obj.data)
    triangles = mesh_arrays.shown_triangles(obj.data)
    vertices = _apply(to_world, own.astype(np.float64))
    return RestShape(own, vertices, triangles, to_world)


def _mended(capture):
    """The Markers of the take. @throws MeanValueError."""
    recording = takes.read(capture.take)
    path, how = _mend(recording, capture)
    if capture.reference_take is None or capture.reference_take == capture.take:
        sample = recording.sample_at(capture.reference_frame)
        frame = float(recording.frames[sample])
        return Markers(recording.rate_hz, recording.labels, path, how, path[sample], recording.frames, frame)
    standing = takes.read(capture.reference_take)
    sample = standing.sample_at(capture.reference_frame)
    places = dict(zip(standing.labels, _mend(standing, capture)[0][sample], strict=True))
    reference = np.array([places.get(label, np.full(3, np.nan)) for label in recording.labels])
    frame = float(standing.frames[sample])
    return Markers(recording.rate_hz, recording.labels, path, how, reference, recording.frames, frame)


def _mend(recording, capture):
    """(path (f, m, 3), how (f, m)): gaps filled as the settings say, then smoothed."""
    spline, rigid = (
        int(seconds * recording.rate_hz + 1e-6) for seconds in (capture.spline_seconds, capture.rigid_seconds)
    )
    path, how = gaps.fill_gaps(recording.positions, spline, rigid)
    if capture.use_low_pass:
        path = filtering.low_pass(path, recording.rate_hz, capture.cutoff_hz)
    return path, how


def _chosen(capture, markers):
    """(numbers of the markers that are used, notes). @throws SceneError if there is none."""
    used = [number for number, label in enumerate(markers.labels) if _is_used(capture, label)]
    seen = [number for number in used if not np.isnan(markers.reference[number]).any()]
    where = f"frame {markers.frame:g} of '{(capture.reference_take or capture.take).name}'"
    if not used:
        raise SceneError("No marker is ticked in the list. Tick those that should move the mesh")
    if not seen:
        raise SceneError(f"No marker is seen in {where}. Choose another Reference Frame")
    unseen = [markers.labels[number] for number in used if number not in seen]
    notes = []
    if unseen:
        notes.append(
            f"{wording.quoted(unseen)} {'is' if len(unseen) == 1 else 'are'} not seen in {where} and got no handle. "
            "Choose a frame that has them, or fill longer gaps"
        )
    return seen, notes


def _is_used(capture, label):
    return label not in capture.pairs or capture.pairs[label].is_used


def _require_vertices(obj, fixed):
    gone = [name for name, vertex in fixed.items() if vertex >= len(obj.data.vertices)]
    if gone:
        raise SceneError(
            f"The mesh has become another: the picked {'point' if len(gone) == 1 else 'points'} of "
            f"{wording.quoted(gone)} {'is' if len(gone) == 1 else 'are'} no longer there. Pick again"
        )


def _alignment(capture, surface, reference, labels, landmarks, fixed):
    """(4 x 4 from the markers' world to where they lie on the mesh, in the world; notes). @throws MeanValueError."""
    if capture.align == 'NONE':
        return np.eye(4), []
    if capture.align == 'AUTO':
        known = {label: place for label, place in zip(labels, landmarks, strict=True) if place}
        sets = [marker_sets.MarkerSet("as chosen", known)] if known else []
        found = alignment.align_to_mesh(reference, labels, surface.vertices, surface.triangles, more_sets=sets)
        is_doubtful = found.certainty < DOUBTFUL or found.quality > POOR
        words = f"{found.words} If it is wrong, pick three points and align by these"
        return found.matrix, [words] if is_doubtful else []
    rows = [row for row, label in enumerate(labels) if label in fixed]
    targets = surface.vertices[[fixed[labels[row]] for row in rows]]
    if len(rows) < LEAST_PAIRS or not fixed_points.span_a_plane(reference[rows]):
        raise SceneError(
            f"Picked Pairs needs the points of at least {LEAST_PAIRS} markers that are not in one line, and "
            f"{wording.counted(len(rows), 'marker')} {'has' if len(rows) == 1 else 'have'} one. Choose a marker in the "
            "list, press the dropper and click its point on the mesh"
        )
    return alignment.similarity(reference[rows], targets), []


def _apply(matrix, points):
    """(..., 3) points, NaN kept."""
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def _filled(how):
    words = {gaps.SPLINE: "filled by splines", gaps.RIGID: "filled by neighbours", gaps.MISSING: "left free"}
    return {text: float(np.mean(how == kind)) for kind, text in words.items()}


def _match(surface, labels, reference, fixed):
    """The matching.Match of the aligned markers (m, 3); those in `fixed` have the vertex given there, and no other."""
    match = matching.match_to_surface(reference, surface.vertices, surface.triangles)
    vertex, distance = match.vertex.copy(), match.distance.copy()
    is_fixed = np.array([label in fixed for label in labels])
    if is_fixed.any():
        vertex[is_fixed] = [fixed[label] for label in labels if label in fixed]
        distance[is_fixed] = np.linalg.norm(reference - surface.vertices[vertex], axis=1)[is_fixed]
        left = np.setdiff1d(np.unique(surface.triangles), list(fixed.values()))
        if len(left) < np.count_nonzero(~is_fixed):
            raise SceneError("The mesh has less vertices than there are markers, and each needs its own. Subdivide it")
        if not is_fixed.all():
            vertex[~is_fixed] = left[matching.one_to_one(match.point[~is_fixed], surface.vertices[left])]
    return _with_markers_at(replace(match, vertex=vertex, distance=distance), surface, reference)


def _with_markers_at(match, surface, places):
    """The Match with offsets as if the markers were at `places` (m, 3)."""
    offset = np.einsum("mji,mj->mi", match.frame, places - surface.vertices[match.vertex])
    return replace(match, offset=offset)


def _targets(capture, surface, markers, match, picked):
    """(f, m, 3): where the vertices go in the world. markers: as aligned; picked (m,) bool."""
    path, reference = markers.path, markers.reference
    if capture.mode == 'RETARGET':
        reference = _on_character(surface, reference, match, picked)
        path = retargeting.retarget(path, markers.reference, reference, markers.rate_hz, markers.landmarks)
        match = _with_markers_at(match, surface, reference)
    return skin.skin_targets(path, reference, match, markers.landmarks)


def _on_character(surface, reference, match, picked):
    """(m, 3): where the markers are on the character: as aligned, but over the points that were picked by hand.

    There they are as far off the skin as the others usually are.
    """
    usual = float(np.median(match.distance[~picked])) if (~picked).any() else 0.0
    normals = Surface(surface.vertices, surface.triangles).normals()[match.vertex]
    return np.where(picked[:, None], surface.vertices[match.vertex] + usual * normals, reference)
