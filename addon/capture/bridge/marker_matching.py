# SPDX-License-Identifier: GPL-3.0-or-later
"""From a take and a mesh to the handles that carry it: mended, aligned, matched, and where each vertex goes.

All of it is in the space of the world, where lengths mean something and there is an up; only what is written for the
object is in its own. Nothing here touches Blender.
The artist is told of what could be better.
"""

import functools
from dataclasses import dataclass, replace

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import motion, point_sets
from ...solver.job import result_of
from ..core import alignment, facing, gaps, landmarks, matching, soles
from ..core import body as bodies
from ..core.body import Body
from ..core.limb_posing import posed_and_actor
from ..core.proportions import with_hips

#: Fewer points leave open how the markers are turned.
LEAST_PAIRS = 3

#: A handle that is let go at once would have its skin jump.
RAMP_SECONDS = 0.08

#: Gaps up to this long are filled by a curve through the marker's own path, longer ones by how its neighbors move.
SPLINE_SECONDS = 0.2

#: Of an automatic alignment (core.alignment.Alignment): from where on the artist is told to look at it.
DOUBTFUL, POOR = 1.1, 0.03


@dataclass(frozen=True, eq=False)
class Matched:
    """What was found for m markers."""

    names: list  # of the markers
    vertices: np.ndarray  # (m,) distinct vertex indices
    rest: np.ndarray  # (m, 3) where these are at rest, in the object's space
    offsets: np.ndarray  # (m, 3) from there to the aligned marker at the reference frame, in the object's space
    distance: np.ndarray  # (m,) how far the marker is from its point, in the world
    targets: np.ndarray  # (f, m, 3) where the vertices go, in the object's space; NaN where nobody knows
    frames: np.ndarray  # (f,) of the scene
    frame: float  # of the reference
    alignment: np.ndarray  # 4 x 4, from where the markers are in the world to the object's space
    size: float  # bounding-box diagonal of the mesh, in its own space
    world_size: float  # the same in the world
    ramp: int  # samples over which a handle fades before and after a gap
    cuffs: list  # core.soles.Cuffs, but for their turns in the object's space
    told: list  # sentences for the report, on what was found
    notes: list  # sentences on what could be better


@dataclass(frozen=True, eq=False)
class Markers:
    """A mended take of m markers."""

    labels: list
    landmarks: tuple  # of each its name or None
    path: np.ndarray  # (f, m, 3)
    reference: np.ndarray  # (m, 3)
    actor: np.ndarray  # (m, 3): the same with the lengths of the one who was captured
    floor: float | None  # its height, of who sits in the reference and was stood up for it


def find(given):
    """The Matched of a bridge.match_input.MatchInput. @throws MeanValueError."""
    return result_of(steps(given))


def steps(given):
    """Generator of (stage, share that is done) that returns the Matched. @throws MeanValueError."""
    options, surface = given.options, given.surface
    yield "filling gaps", 0.0
    path = _mended(given, given.recording)
    sample = int(np.abs(given.standing.frames - options.reference_frame).argmin())
    frame = float(given.standing.frames[sample])
    markers, notes = _chosen(given, frame, path, _reference(given, sample))
    yield "aligning", 0.3
    body = Body(surface, given.is_skeleton)
    to_mesh, words = _alignment(given, markers, body)
    path, rate = motion.apply(to_mesh, markers.path), given.recording.rate_hz
    laid = motion.apply(to_mesh, markers.reference)
    if markers.floor is not None:  # how high who sits would stand is a guess
        path[..., 2] += body.ground - motion.apply(to_mesh, np.array([0.0, 0.0, markers.floor]))[2]
    markers = replace(markers, path=path, reference=laid, actor=laid)
    if options.pose_limbs and options.align != 'NONE':
        yield "posing limbs", 0.4
        rest, _, names = with_hips(laid, path, markers.landmarks)  # legs turn about the hips of all frames
        laid, actor = (points[: len(laid)] for points in posed_and_actor(rest, names, body))
        markers = replace(markers, reference=laid, actor=actor)
    yield "matching", 0.5
    far = bodies.far(surface.nearest(laid)[3] / body.height, markers.landmarks, options.pose_limbs)
    far = {markers.labels[row] for row in far} - given.fixed.keys()
    if far and options.is_of_body:
        return (yield from steps(replace(given, others=given.others | far)))
    fixed = {row: given.fixed[label] for row, label in enumerate(markers.labels) if label in given.fixed}
    match = matching.match_to_surface(laid, surface, fixed)
    if options.mode == 'RETARGET':
        yield "retargeting", 0.6
        if given.picked.isdisjoint(markers.labels):
            notes.append(
                "Retarget takes the character's lengths from picked points, and none are picked. Pick the points of "
                "hips, knees, ankles, shoulders, elbows and wrists, and match again"
            )
        # On the character markers are where they were aligned, but those whose points were picked by hand are over
        # these, as far off the skin as the others usually are.
        picked = np.array([label in given.picked for label in markers.labels])
        usual = float(np.median(match.distance[~picked])) if (~picked).any() else 0.0
        points = surface.vertices[match.vertex]
        character = np.where(picked[:, None], points + usual * surface.normals()[match.vertex], laid)
        moved = matching.retarget(path, markers.actor, character, markers.landmarks)
        markers, match = replace(markers, path=moved, reference=character), match._replace(offset=character - points)
    yield "following the skin", 0.7
    found = []
    if options.keep_floor:
        level = body.ground + options.floor_height
        path, found = soles.on_floor(markers, path, match.vertex, body, level, rate, markers.floor is not None)
        markers = replace(markers, path=path)
    targets = matching.skin_targets(markers.path, markers.reference, match.offset, markers.landmarks)
    yield "laying cuffs", 0.8
    to_object = np.linalg.inv(given.to_world)
    yield "making handles", 0.9
    rest = given.own[match.vertex].astype(np.float64)
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
        size=point_sets.bounding_box_diagonal(given.own),
        world_size=point_sets.bounding_box_diagonal(surface.vertices),
        ramp=round(RAMP_SECONDS * given.recording.rate_hz),
        cuffs=_cuffs(given, markers, match, found, to_object),
        told=[given.recognition],
        notes=[*notes, *words],
    )


def _mended(given, recording):
    """(f, m, 3), filled and filtered; not to be written to."""
    path, rate, options = recording.positions, recording.rate_hz, given.options
    longest = tuple(int(min(most, options.rigid_seconds) * rate + 1e-6) for most in (SPLINE_SECONDS, np.inf))
    return _filled(path.tobytes(), path.shape, longest, rate, options.cutoff_hz)


@functools.lru_cache(maxsize=2)  # a take and its reference: picking points, one after the other, does not change them
def _filled(content, shape, longest, rate_hz, cutoff_hz):
    path = gaps.fill_gaps(np.frombuffer(content).reshape(shape), *longest)
    return path if cutoff_hz is None else gaps.low_pass(path, rate_hz, cutoff_hz)


def _reference(given, sample):
    """(m, 3): where the markers of the take are at the reference; NaN for what is not seen there."""
    path, labels = _mended(given, given.standing), given.standing.labels
    known = [given.landmarks.get(label) for label in labels]
    places = dict(zip(labels, soles.standing(path, sample, known, given.standing.rate_hz), strict=True))
    return np.array([places.get(label, np.full(3, np.nan)) for label in given.recording.labels])


def _chosen(given, frame, path, reference):
    """(the Markers that are used, seen in the reference, on the body; notes). @throws SceneError if there is none."""
    labels = given.recording.labels
    used = [number for number, label in enumerate(labels) if label in given.used]
    seen = [number for number in used if not np.isnan(reference[number]).any()]
    unseen = [labels[number] for number in used if number not in seen]
    where = f"frame {frame:g} of '{given.standing.name}'"
    if not seen:
        other = "Frame" if {*labels} & {*given.standing.labels} else "Take"
        raise SceneError(f"No marker of the take is in {where}. Choose another Reference {other}")
    names = [labels[number] for number in seen]
    known = np.array([bool(given.landmarks[name]) or name in given.fixed for name in names])
    kept = np.ones(len(names), bool)
    if given.options.is_of_body:
        kept = known if given.is_skeleton else bodies.goes_along(path[:, seen], reference[seen], known)
        kept = kept & [name not in given.others or name in given.fixed for name in names]
    if not kept.any():
        raise SceneError(
            f"None of {wording.counted(len(seen), 'joint')} has a known place on the body. Choose the Landmark of "
            "hips, knees, ankles, neck, shoulders, elbows and wrists in the list"
        )
    notes = []
    if not kept.all():
        what, why = ("joint", "without a known place") if given.is_skeleton else ("marker", "that nothing shows to be")
        left_out = [names[row] for row in np.flatnonzero(~kept)]
        notes.append(
            f"No handle for {wording.counted(len(left_out), what)} {why} on the body: {wording.quoted(left_out)}. "
            "Choose a Landmark, or pick the point, of those that should have one"
        )
    if unseen:
        notes.append(
            f"Not seen in {where}, and without a handle: {wording.quoted(unseen)}. Choose a frame that has them, or "
            "fill longer gaps"
        )
    frames, asked = given.standing.frames, given.options.reference_frame
    if not frames[0] - 1.0 <= asked <= frames[-1] + 1.0:
        notes.append(
            f"'{given.standing.name}' has no frame {asked:g}: it goes from {frames[0]:g} to {frames[-1]:g}. "
            f"Frame {frame:g} was taken as the reference"
        )
    names, seen = [names[row] for row in np.flatnonzero(kept)], np.array(seen)[kept]
    places, path, seated = tuple(given.landmarks[name] for name in names), path[:, seen], reference[seen]
    stands, floor = seated, min(0.0, np.nanmin(path[..., 2], initial=0.0))
    if given.options.align == 'AUTO':
        stands = alignment.stood_up(seated, places, floor)
    if facing.walks_backward(stands, places):
        notes.append("By left and right of the names the feet point backward: they are exchanged, or it is mirrored")
    return Markers(names, places, path, stands, stands, None if stands is seated else floor), notes


def _alignment(given, markers, body):
    """(4 x 4 from the markers' world to where they lie on the mesh, in the world; notes). @throws MeanValueError."""
    if given.to_object is not None:
        return given.to_world @ given.to_object, []
    if given.options.align == 'NONE':
        return motion.IDENTITY, _unheld(markers)
    if given.options.align == 'AUTO':
        found = alignment.align_to_mesh(markers.reference, markers.landmarks, body)
        notes = _unheld(markers, f", scaled by {found.scale:.3g}")
        other = ". Another way to look fits nearly as well" if found.certainty < DOUBTFUL else ""
        if other or found.quality > POOR:
            notes.append(
                f"Two of three markers lie {wording.share(found.quality)} of the height from the skin, scaled by "
                f"{found.scale:.3g}{other}. If it is wrong, pick three points and align by these"
            )
        return found.matrix, notes
    rows = [row for row, label in enumerate(markers.labels) if label in given.fixed]
    picked = markers.reference[rows], given.surface.vertices[[given.fixed[markers.labels[row]] for row in rows]]
    if len(rows) < LEAST_PAIRS or not all(map(point_sets.span_a_plane, picked)):
        raise SceneError(
            f"Picked Pairs needs the points of at least {LEAST_PAIRS} markers that are not in one line, and "
            f"{wording.counted(len(rows), 'marker')} {'has' if len(rows) == 1 else 'have'} one. Choose a marker in the "
            "list, press Pick Point and click its point on the mesh"
        )
    return alignment.similarity(*picked), _unheld(markers)


def _unheld(markers, scaled=""):
    """[A sentence] on limbs that no markers hold, of what is a body by its names or was aligned as one, `scaled`."""
    known, unknown = sum(map(bool, markers.landmarks)), landmarks.unknown_limbs(markers.landmarks)
    if not unknown or not (scaled or known >= bodies.ENOUGH):
        return []
    return [
        f"Nothing holds {wording.listed(unknown)} to their ends, nor tells how they lie: the place on the body is "
        f"known of {known} of {wording.counted(len(markers.labels), 'marker')}{scaled}. If there are markers of "
        "shoulders, elbows, wrists, hips, knees and ankles, choose their Landmark and match again; else pin what "
        "should stay"
    ]


def _cuffs(given, markers, match, found, to_object):
    """[core.soles.Cuff]: places and radii are in the object's space, turns in the world."""
    # Joints are inside, nearly in one line.
    names = (None,) * len(markers.labels) if given.is_skeleton or not given.options.is_of_body else markers.landmarks
    of_limbs = soles.find_cuffs(markers.path, markers.reference, names, match.vertex, given.surface)
    scale = np.cbrt(abs(np.linalg.det(to_object[:3, :3])))
    result = []
    for cuff in (*found, *of_limbs):
        centre, centres = (motion.apply(to_object, points) for points in (cuff.centre, cuff.centres))
        result.append(replace(cuff, centre=centre, radius=scale * cuff.radius, centres=centres))
    return result
