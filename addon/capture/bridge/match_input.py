# SPDX-License-Identifier: GPL-3.0-or-later
"""All that matching markers with a mesh needs to know of Blender, read at once, as arrays and plain values."""

from dataclasses import dataclass

import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene import mesh_arrays, shape_keys
from . import marker_pairs, marker_presets, takes


@dataclass(frozen=True, eq=False)
class RestShape:
    """own: n x 3 in the object's space, vertices: n x 3 in the world; triangles t x 3; to_world 4 x 4."""

    own: np.ndarray
    vertices: np.ndarray
    triangles: np.ndarray
    to_world: np.ndarray


@dataclass(frozen=True, eq=False)
class MatchInput:
    """A mesh, its take, and what the artist wants.

    recording  the take; standing  the takes.Recording that has the reference, which may be the same
    reference_frame  of the scene; reference_name  of the take that has it
    used       markers that are ticked; landmarks  {marker: landmark or None}
    recognition  how the names of the markers were known, in words
    fixed      {marker: vertex} to be kept; picked  those of them that were picked by hand
    to_object  4 x 4 from the markers' world to the object's space, to be kept, or None: as `align` says
    align, pose_limbs, use_cuffs, mode, spline_seconds, rigid_seconds, cutoff_hz  as in MEANVALUE_PG_capture; cutoff_hz
               is None without a filter
    notes      sentences
    """

    surface: RestShape
    recording: takes.Recording
    standing: takes.Recording
    reference_frame: float
    reference_name: str
    used: frozenset
    landmarks: dict
    recognition: str
    fixed: dict
    picked: dict
    to_object: np.ndarray | None
    align: str
    pose_limbs: bool
    use_cuffs: bool
    mode: str
    spline_seconds: float
    rigid_seconds: float
    cutoff_hz: float | None
    notes: list


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


def read(obj):
    """The MatchInput of a mesh object. @throws SceneError."""
    picked = {pair.name: pair.vertex for pair in obj.meanvalue.capture.pairs if pair.is_picked and pair.vertex >= 0}
    return _read(obj, picked, picked, None)


def read_again(obj, name, vertex):
    """As read(), with all as it was last matched but for the marker `name`, whose `vertex` is picked now."""
    capture = obj.meanvalue.capture
    picked = {pair.name: pair.vertex for pair in capture.pairs if pair.is_picked and pair.vertex >= 0}
    matched = {pair.name: pair.vertex for pair in marker_pairs.matched(obj) if pair.vertex >= 0}
    alignment = np.array(capture.alignment, np.float64).reshape(4, 4)
    return _read(obj, {**matched, **picked, name: vertex}, {**picked, name: vertex}, alignment)


def _read(obj, fixed, picked, to_object):
    capture = obj.meanvalue.capture
    surface = _surface(obj)
    _require_vertices(obj, fixed)
    recording = takes.read(capture.take)
    other = capture.reference_take
    standing = recording if other is None or other == capture.take else takes.read(other)
    landmarks, recognition, notes = marker_presets.recognised(capture, recording.labels)
    return MatchInput(
        surface=surface,
        recording=recording,
        standing=standing,
        reference_frame=capture.reference_frame,
        reference_name=(other or capture.take).name,
        used=frozenset(label for label in recording.labels if _is_used(capture, label)),
        landmarks=dict(zip(recording.labels, landmarks, strict=True)),
        recognition=recognition,
        fixed=fixed,
        picked=picked,
        to_object=to_object,
        align=capture.align,
        pose_limbs=capture.pose_limbs and capture.align != 'NONE',
        use_cuffs=capture.use_cuffs,
        mode=capture.mode,
        spline_seconds=capture.spline_seconds,
        rigid_seconds=capture.rigid_seconds,
        cutoff_hz=capture.cutoff_hz if capture.use_low_pass else None,
        notes=notes,
    )


def _is_used(capture, label):
    return label not in capture.pairs or capture.pairs[label].is_used


def _surface(obj):
    """@throws SceneError."""
    to_world = np.array(obj.matrix_world, np.float64)
    if not np.linalg.cond(to_world[:3, :3]) < 1e9:
        raise SceneError(f"'{obj.name}' is scaled to nothing. Give it a size")
    own = shape_keys.rest_positions(obj.data)
    vertices = own.astype(np.float64) @ to_world[:3, :3].T + to_world[:3, 3]
    return RestShape(own, vertices, mesh_arrays.shown_triangles(obj.data), to_world)


def _require_vertices(obj, fixed):
    gone = [name for name, vertex in fixed.items() if vertex >= len(obj.data.vertices)]
    if gone:
        raise SceneError(
            f"The mesh has become another: the picked {'point' if len(gone) == 1 else 'points'} of "
            f"{wording.quoted(gone)} {'is' if len(gone) == 1 else 'are'} no longer there. Pick again"
        )
