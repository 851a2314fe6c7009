# SPDX-License-Identifier: GPL-3.0-or-later
"""Anchors and region in the 3D View: what is shown of an object, remembered so that a redraw costs nearly nothing, and
drawing it.

Positions are read every time, in 0.2 ms for 50,000 vertices: of what a handler writes Blender tells no handler again.
The rest takes a hundred times as long: it is the same array until object_model says that it may be another.
"""

from dataclasses import dataclass, replace

import gpu
import numpy as np
from gpu_extras.batch import batch_for_shader

from ... import compat
from ...scene import kept, mesh_arrays, mirrors, rig_space, shape_keys
from ...scene.core.point_sets import tinted_faces
from ...widgets.overlay import drawing
from ..bridge import members, region, scene_input, targets
from ..core import bind_input, joints
from ..operators import tool_choice

#: Size of an anchor at interface scale 1: small, since the surface has to show between them.
POINT_PIXELS = 4.0

#: Color and opacity of what moves freely.
TINT = (0.25, 0.6, 1.0, 0.2)

#: The same of what would move freely after a press.
HOVER = (0.35, 0.7, 1.0, 0.45)

#: How much closer to the eye things are drawn than they are, so that they are not half hidden by the surface that they
#: lie on; a share of their distance.
TINT_CLOSER = 0.0025
POINTS_CLOSER = 0.005


@dataclass(frozen=True, eq=False)
class Look:
    """What was read of an object, and where that is to be seen, in object space."""

    stamp: tuple | None  # of the ObjectModel that was read
    #: k int32, of all enabled handles, those that are not surrounded by others; with Symmetric on both sides.
    anchors: np.ndarray
    handles: np.ndarray  # k int32, number of the enabled handle of each
    tinted: np.ndarray  # p int32, vertices of the region's faces, or of those at joints; none if there are none
    freedom: np.ndarray  # p float32, how freely these move, 0 to 1
    corners: np.ndarray  # q x 3 int32, triangles of them, positions in `tinted`
    positions: np.ndarray  # n x 3 float32, where all vertices are to be seen
    of_joints: bool = False  # what is tinted is where it bends
    palette: tuple = ()  # (red, green, blue, alpha) of each enabled handle

    @property
    def points(self):
        """k x 3 float32."""
        return self.positions[self.anchors]

    @property
    def colors(self):
        """k x 4 float32, of the points."""
        return np.array(self.palette, np.float32).reshape(-1, 4)[self.handles]

    @property
    def tint(self):
        """p x 3 float32."""
        return self.positions[self.tinted]


_NONE, _NO_TRIANGLES = np.empty(0, np.int32), np.empty((0, 3), np.int32)

#: Until the mesh is read.
NOTHING = Look(None, _NONE, _NONE, _NONE, np.empty(0, np.float32), _NO_TRIANGLES, np.empty((0, 3), np.float32))

_known = {}  # session key: Look


def look_of(obj):
    """The Look of a mesh object; the same one as long as nothing changed. Not for modes with a mesh of their own."""
    if not (obj.meanvalue.handles or obj.meanvalue.roi_group):
        return NOTHING
    key = compat.session_key(obj)
    stamp = scene_input.shown(obj).stamp(obj)
    known, positions = _known.get(key, NOTHING), rig_space.shown_positions(obj)
    is_usable = known is not NOTHING and len(known.positions) == len(positions)
    is_usable = is_usable and (known.stamp[0], known.of_joints) == (stamp[0], obj.meanvalue.show_joints)
    if not is_usable or (known.stamp != stamp and obj.mode == 'OBJECT'):  # a stroke of a brush is an edit
        known = _read(obj, stamp, positions)
    palette = tuple((*handle.color, 1.0) for handle in targets.enabled_handles(obj))
    if known.palette != palette or not np.array_equal(known.positions, positions):
        known = replace(known, positions=positions, palette=palette)
    _known[key] = known
    return known


def _read(obj, stamp, positions):
    anchors, handles = bind_input.anchor_layout(members.of(obj, targets.enabled_handles(obj)))
    rest, faces = shape_keys.rest_positions(obj.data), kept.faces(obj.data)
    rest = np.nan_to_num(rest, posinf=0.0, neginf=0.0)  # of which others tell: an error would end all drawing
    twins = mirrors.partners(obj, rest)
    if twins is not None:  # and the images that have no handle of their own
        is_more = (twins[anchors] >= 0) & ~np.isin(twins[anchors], anchors)
        anchors, handles = np.append(anchors, twins[anchors][is_more]), np.append(handles, handles[is_more])
    anchors, handles = _outlined(anchors, handles, len(obj.data.vertices), *faces)
    tinted, corners, freedom = _NONE, _NO_TRIANGLES, np.empty(0)
    found, of_joints = scene_input.known(obj), obj.meanvalue.show_joints
    if of_joints and found is not None and found.stiffness is not None:
        freedom = np.clip(1.0 - np.log(found.stiffness) / np.log(joints.STIFF), 0.0, 1.0)  # what limbs have more
    elif not of_joints and obj.meanvalue.roi_group in obj.vertex_groups:
        copies = kept.copies(obj, rest)
        freedom = scene_input.effective_region(region.known_weights(obj, 1.0), copies, twins)
    if len(freedom):
        tinted, corners = tinted_faces(mesh_arrays.shown_triangles(obj.data, faces[0]), freedom > 0.0)
        freedom = freedom[tinted]
    return Look(stamp, anchors, handles, tinted, freedom.astype(np.float32), corners, positions, of_joints)


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


_drawn = {}  # function that makes a batch, and a color: (what it made the last one of, that batch, its shader)


def paint(context, obj):
    look, found = look_of(obj), tool_choice.would_follow(context, obj)
    with drawing(context, obj, 'NONE' if obj.show_in_front else 'LESS_EQUAL', POINT_PIXELS):
        if len(look.corners) and obj.mode == 'OBJECT':  # Weight Paint shows the region itself
            _draw_closer(context, TINT_CLOSER, look, _faces, TINT)
        if found is not None and len(found.corners):
            _draw_closer(context, TINT_CLOSER, found, _faces, HOVER)
        if len(look.points):
            _draw_closer(context, POINTS_CLOSER, look, _points)


def _draw_closer(context, share, shown, make, *color):
    """Draws the (batch, shader) that make(shown, *color) gives, which are kept for as long as the same is shown."""
    key = make, *color
    if key not in _drawn or _drawn[key][0] is not shown:
        _drawn[key] = shown, *make(shown, *color)
    _, batch, shader = _drawn[key]
    with gpu.matrix.push_pop_projection():
        projection = gpu.matrix.get_projection_matrix()
        gpu.matrix.load_projection_matrix(closer(projection, context.region_data.view_distance, share))
        batch.draw(shader)


def closer(projection, view_distance, share):
    """The 4 x 4 projection with everything nearer to the eye by `share`, and at the same place in the picture."""
    moved = projection.copy()
    is_orthographic = projection[3][3] > 0.5
    if is_orthographic:
        moved[2][3] += projection[2][2] * share * view_distance
    else:
        moved[2][3] *= 1.0 + share
    return moved


def _points(look):
    shader = compat.shader("POINT_FLAT_COLOR")
    return batch_for_shader(shader, 'POINTS', {"pos": look.points, "color": look.colors}), shader


def _faces(shown, color):
    """The less a vertex moves, the fainter it is."""
    colors = np.tile(np.array(color, np.float32), (len(shown.tint), 1))
    colors[:, 3] *= shown.freedom
    shader = compat.shader("SMOOTH_COLOR")
    return batch_for_shader(shader, 'TRIS', {"pos": shown.tint, "color": colors}, indices=shown.corners), shader


def forget():
    _drawn.clear()
    _known.clear()
