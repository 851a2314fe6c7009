# SPDX-License-Identifier: GPL-3.0-or-later
"""All that matching markers with a mesh needs to know of Blender, read at once, as arrays and plain values.
The places on the body are those that names of markers, and the artist, tell."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import actions, mesh_arrays, shape_keys, subject
from ...scene.core import motion
from ...scene.surface import Surface
from ..core import landmarks, marker_sets
from . import marker_pairs, takes

#: Settings of MEANVALUE_PG_capture that matching goes by.
OPTIONS = "reference_frame", "align", "pose_limbs", "keep_floor", "floor_height", "mode", "rigid_seconds"


@dataclass(frozen=True, eq=False)
class MatchInput:
    """A mesh, its take, and what the artist wants."""

    surface: Surface  # of its rest shape in the world
    own: np.ndarray  # (n, 3) the same vertices in the object's space
    to_world: np.ndarray  # 4 x 4 between them
    recording: takes.Recording  # the take
    standing: takes.Recording  # the take with the reference frame, which may be the same
    used: frozenset  # markers that are ticked
    landmarks: dict  # {marker: landmark or None}, of those that are used
    others: frozenset  # markers whose names say that something else wears them
    is_skeleton: bool  # the markers are joints
    recognition: str  # how the names of the markers were known, in words
    fixed: dict  # {marker: vertex} to be kept
    picked: frozenset  # the names of those of them that were picked by hand
    to_object: np.ndarray | None  # 4 x 4 from the markers' world to the object's space; None: as `align` says
    options: SimpleNamespace  # OPTIONS, cutoff_hz, which is None without a filter, and whether the mesh is a body


def problem(obj):
    """Why nothing can be matched, as far as is known before it is tried, or None."""
    capture = obj.meanvalue.capture
    if not takes.is_take(capture.take):
        return takes.NOT_CHOSEN
    if len(obj.data.polygons) == 0:
        return f"'{obj.name}' has no faces, so no marker can be laid on it. Choose a mesh with a surface"
    if capture.pairs and not any(pair.is_used for pair in capture.pairs):
        return "No marker is ticked in the list. Tick those that should move the mesh"
    return None


def reference_frame(obj):
    """The frame of the scene in which the person stands as the mesh does."""
    return obj.meanvalue.capture.reference_frame


def read(obj):
    """The MatchInput of a mesh object. @throws SceneError."""
    picked = _picked(obj)
    return _read(obj, picked, picked, None)


def facts(obj, given):
    """What matching goes by, and the keys that it writes over, to be compared."""
    paths = [given.recording, given.standing]
    arrays = [given.own, given.to_world, given.surface.triangles, *(each.frames for each in paths)]
    arrays += [each.positions for each in paths]
    for control in filter(None, (pair.control for pair in marker_pairs.matched(obj))):
        arrays += [array for axis in range(3) for array in actions.read_keys(control, "location", axis)]
    return [array.tobytes() for array in arrays], given.used, given.landmarks, given.fixed, vars(given.options)


def read_again(obj, name, vertex):
    """As read(), with all as it was last matched but for the marker `name`, whose `vertex` is picked now."""
    picked = {**_picked(obj), name: vertex}
    matched = {pair.name: pair.vertex for pair in marker_pairs.matched(obj) if pair.vertex >= 0}
    alignment = np.array(obj.meanvalue.capture.alignment, np.float64).reshape(4, 4)
    return _read(obj, {**matched, **picked}, picked, alignment)


def _picked(obj):
    return {pair.name: pair.vertex for pair in obj.meanvalue.capture.pairs if pair.is_picked and pair.vertex >= 0}


def _read(obj, fixed, picked, to_object):
    capture = obj.meanvalue.capture
    gone = [name for name, vertex in fixed.items() if vertex >= len(obj.data.vertices)]
    if gone:
        raise SceneError(
            f"The mesh has become another: picked points are no longer there ({wording.quoted(gone)}). Pick again"
        )
    recording = takes.read(capture.take)
    other = capture.reference_take
    standing = recording if other is None or other == capture.take else takes.read(other)
    used = [label for label in recording.labels if label not in capture.pairs or capture.pairs[label].is_used]
    is_skeleton = capture.take.meanvalue.is_skeleton
    known, others, recognition = recognised(capture, used, is_skeleton)
    options = SimpleNamespace(**{name: getattr(capture, name) for name in OPTIONS})
    options.cutoff_hz, options.is_of_body = capture.cutoff_hz if capture.use_low_pass else None, True
    to_world = subject.to_world(obj)
    own = shape_keys.rest_positions(obj.data)
    return MatchInput(
        surface=Surface(motion.apply(to_world, own), mesh_arrays.shown_triangles(obj.data)),
        own=own,
        to_world=to_world,
        recording=recording,
        standing=standing,
        used=frozenset(used),
        landmarks=known,
        others=others,
        is_skeleton=is_skeleton or landmarks.has_joints(known.values()),
        recognition=recognition,
        fixed=fixed,
        picked=frozenset(picked),
        to_object=to_object,
        options=options,
    )


def recognised(capture, labels, is_skeleton):
    """({label: landmark or None}, the labels of other subjects than the person, words on what the names tell). What
    the artist chose in the list comes before what the name tells. @throws SceneError if that is no landmark."""
    recognition = marker_sets.recognise(labels, is_skeleton)
    own = [capture.pairs[label].landmark if label in capture.pairs else "" for label in labels]
    unknown = sorted({landmark for landmark in own if landmark and landmarks.place_of(landmark) is None})
    if unknown:
        raise SceneError(
            f"{wording.quoted(unknown)} {'is no landmark' if len(unknown) == 1 else 'are no landmarks'}. Choose from "
            "the list that opens in the field, or clear it"
        )
    places = tuple(mine or by_name for mine, by_name in zip(own, recognition.landmarks, strict=True))
    chosen = sum(map(bool, own))
    by_hand = f", {wording.counted(chosen, 'landmark')} chosen by hand" if chosen else ""
    others = frozenset(labels[number] for number in recognition.others if not places[number])
    words = f"{sum(map(bool, recognition.landmarks))} of {len(labels)} names are known{by_hand}"
    return dict(zip(labels, places, strict=True)), others, words


def candidates():
    """Names of all landmarks, with sides where a body has two."""
    for name, place in landmarks.PLACES.items():
        is_limb = any("*" in segment for segment in place.segments)
        yield from ([] if is_limb else [name])
        yield from (f"{name}.L", f"{name}.R")
