# SPDX-License-Identifier: GPL-3.0-or-later
"""What the overlay shows of an object, as arrays, remembered so that nearly nothing is done for a redraw.

Positions are read every time, which takes 0.2 ms for 50,000 vertices: Blender does not tell of every change (what is
written by a handler of an update is evaluated without calling handlers again). Vertex groups and faces, which take a
hundred times as long, are read again when object_model says that they may be others, and the object has been left alone
for a moment. What did not change is the same array as before.
"""

from dataclasses import dataclass

import numpy as np

from ... import compat
from ...scene import mesh_arrays, mirrors, object_model, shape_keys, shared_readings, shown_shape
from ..core import bind_input, tinted_faces
from . import scene_input, targets


@dataclass(frozen=True, eq=False)
class Look:
    """Points and faces to draw, in object space.

    points  k x 3 float32, colors  k x 4 float32: the anchors of all enabled handles that are not surrounded by others,
            with Symmetric on both sides
    tint    p x 3 float32, freedom p float32, corners q x 3 int32 into them: the region's faces, as Subdivision shows
            them, and how freely their vertices move, 0 to 1; none if no region is set
    """

    points: np.ndarray
    colors: np.ndarray
    tint: np.ndarray
    freedom: np.ndarray
    corners: np.ndarray


#: Until the mesh is read.
NOTHING = Look(
    points=np.empty((0, 3), np.float32),
    colors=np.empty((0, 4), np.float32),
    tint=np.empty((0, 3), np.float32),
    freedom=np.empty(0, np.float32),
    corners=np.empty((0, 3), np.int32),
)


@dataclass(eq=False)
class _Known:
    stamp: object_model.Stamp
    vertex_count: int  # as shown
    anchors: np.ndarray  # k int32
    handles: np.ndarray  # k int32: number of the enabled handle
    tint_vertices: np.ndarray  # p int32
    tint_freedom: np.ndarray  # p float32
    tint_corners: np.ndarray  # q x 3 int32
    look: Look | None = None
    look_positions: np.ndarray | None = None  # n x 3 float32, what `look` was made of
    look_colors: tuple = ()


_known = {}  # session key: _Known


def clear():
    _known.clear()


def look(obj):
    """The Look of a mesh object; the same one as long as nothing changed. Not for modes with a mesh of their own."""
    key = compat.session_key(obj)
    model = scene_input.model(obj)
    model.is_watched = True
    known, positions = _known.get(key), shown_shape.all_positions(obj)
    is_same_mesh = known is not None and known.vertex_count == len(positions)
    is_same_list = known is not None and known.stamp.signature == model.stamp(obj).signature
    if not (is_same_mesh and is_same_list and model.was_told_within(object_model.QUIET_SECONDS)):
        reading = shared_readings.finished(obj, scene_input.HandleReading)
        if reading is not None and not (is_same_mesh and known.stamp == model.stamp(obj)):
            known = _known[key] = _read(obj, model.stamp(obj), reading, positions)
        elif reading is None and (not is_same_mesh or known.look is None):
            return NOTHING
        elif reading is None and not is_same_list:
            return known.look  # its handles may be others than those that there are now
    colors = tuple((*handle.color, 1.0) for handle in targets.enabled_handles(obj))
    if known.look is None or known.look_colors != colors or not np.array_equal(known.look_positions, positions):
        known.look = _look(known, positions, colors)
        known.look_positions, known.look_colors = positions, colors
    return known.look


def _read(obj, stamp, reading, positions):
    names = [handle.name for handle in targets.enabled_handles(obj)]
    region = obj.meanvalue.roi_group
    members = reading.members
    anchors, handles = bind_input.anchor_layout([members.get(name, np.empty(0, np.int32)) for name in names])
    rest = shape_keys.rest_positions(obj.data)
    twins = mirrors.partners(obj, rest, *reading.faces)
    anchors, handles = _outlined(*_on_both_sides(anchors, handles, twins), len(obj.data.vertices), *reading.faces)
    vertices, corners, freedom = np.empty(0, np.int32), np.empty((0, 3), np.int32), np.empty(0)
    if region in members:
        freedom = scene_input.region_weights(obj, reading)
        freedom = scene_input.effective_region(obj, freedom, rest, None if twins is None else twins[None])
        vertices, corners, freedom = _tint(obj, reading.faces, freedom, positions)
    return _Known(stamp, len(positions), anchors, handles, vertices, freedom.astype(np.float32), corners)


def _tint(obj, faces, freedom, positions):
    """(vertices, corners, freedom of these vertices) of the mesh that is shown."""
    subdivided = shown_shape.subdivided(obj)
    if subdivided is None:
        triangles = mesh_arrays.shown_triangles(obj.data)
        vertices, corners = tinted_faces.tinted_faces(triangles, *faces, freedom > 0.0)
        return vertices, corners, freedom[vertices]
    quads, _starts = mesh_arrays.faces(subdivided)
    triangles, pieces = mesh_arrays.shown_triangles(subdivided), len(quads) // (4 * len(faces[0]))
    vertices, corners = tinted_faces.tinted_faces(triangles, *faces, freedom > 0.0, pieces)
    return vertices, corners, tinted_faces.freedom_of_pieces(freedom, vertices, positions, quads, *faces)


def _on_both_sides(anchors, handles, twins):
    """Anchors and the numbers of their handles, with the images that have no handle of their own."""
    if twins is None:
        return anchors, handles
    images = twins[anchors]
    is_more = (images >= 0) & ~np.isin(images, anchors)
    return np.append(anchors, images[is_more]), np.append(handles, handles[is_more])


def _outlined(anchors, handles, vertex_count, corners, starts):
    """Anchors and the numbers of their handles, without those that are amid others: a patch must not hide what it
    holds. All, where a handle has a whole part."""
    if len(starts) == 0:
        return anchors, handles
    is_anchor = np.zeros(vertex_count, bool)
    is_anchor[anchors] = True
    is_amid = np.logical_and.reduceat(is_anchor[corners], starts)
    of_each = np.repeat(is_amid, np.diff(np.append(starts, len(corners))))
    is_shown = np.ones(vertex_count, bool)
    is_shown[corners] = False
    is_shown[corners[~of_each]] = True
    is_shown = is_shown[anchors]
    is_shown |= ~np.isin(handles, handles[is_shown])
    return anchors[is_shown], handles[is_shown]


def _look(known, positions, colors):
    return Look(
        points=positions[known.anchors],
        colors=np.array(colors, np.float32).reshape(-1, 4)[known.handles],
        tint=positions[known.tint_vertices],
        freedom=known.tint_freedom,
        corners=known.tint_corners,
    )
