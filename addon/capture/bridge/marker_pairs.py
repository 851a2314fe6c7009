# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of markers of a mesh: which point each has, and which control and handle were made for it. The
overlay shows a line from each, at the reference frame, to its point."""

import bpy
import numpy as np

from ...posing.bridge import controls
from ...scene import rig_space, subject
from ...widgets.overlay import NOTHING, Lines, draw_lines
from . import takes


def list_markers(capture):
    """Gives every marker of the chosen take an entry. Those of others go, unless they have a control."""
    wanted = takes.markers(capture.take) if takes.is_take(capture.take) else []
    wanted = [empty.meanvalue.marker for empty in wanted]
    for index in reversed(range(len(capture.pairs))):
        pair = capture.pairs[index]
        if pair.name not in wanted and pair.control is None:
            capture.pairs.remove(index)
    for label in wanted:
        if label not in capture.pairs:
            capture.pairs.add().name = label


def begin_with_take(capture, _context):
    """The list shows the markers of the take, and the reference is a frame that has all of them, if there is one."""
    list_markers(capture)
    source = capture.reference_take or capture.take
    if source is not None:
        capture.reference_frame = source.meanvalue.fullest_frame


def list_problem(obj):
    """Why there is no marker to work on, or None."""
    if obj.meanvalue.capture.pairs:
        return None
    return f"'{obj.name}' has no markers yet. Choose a take in Motion Capture"


def handle_index(obj, pair):
    """Where the handle of a pair is in `obj.meanvalue.handles`, or None.

    A handle that the artist gave another control is no longer the marker's.
    """
    handles = obj.meanvalue.handles
    return next((n for n, handle in enumerate(handles) if handle.marker == pair.name and handle.made_control), None)


def handle_of(obj, pair):
    """The handle of a pair, or None."""
    index = handle_index(obj, pair)
    return None if index is None else obj.meanvalue.handles[index]


def matched(obj):
    """The pairs of a mesh that have a handle."""
    return [pair for pair in obj.meanvalue.capture.pairs if handle_index(obj, pair) is not None]


def meant(obj, active):
    """The pair that the artist means: of the active object (its control or marker), else of the list; or None."""
    capture = obj.meanvalue.capture
    own = next((pair for pair in capture.pairs if active is not None and pair.control == active), None)
    if own is not None:
        return own
    if active is not None and takes.of_marker(active) in {capture.take, capture.reference_take} - {None}:
        return capture.pairs.get(active.meanvalue.marker)
    return active_pair(obj)


def active_pair(obj):
    """The pair that is the active one, or None."""
    capture = obj.meanvalue.capture
    return capture.pairs[capture.active_pair] if capture.active_pair < len(capture.pairs) else None


def select_active(obj):
    """Selects the control of the marker whose line the artist chose or, before it is matched, its Empty in the take."""
    pair, take = active_pair(obj), obj.meanvalue.capture.take
    if pair is None or bpy.context.mode != 'OBJECT':
        return
    shown = pair.control
    if shown is None and takes.is_take(take):
        shown = next((empty for empty in takes.markers(take) if empty.meanvalue.marker == pair.name), None)
    if shown not in {None, bpy.context.object} and shown.name in bpy.context.view_layer.objects:
        subject.choose(shown)


def note_active(active):
    """Makes the pair of a control that the artist has just made active the active one of the list."""
    obj = controls.owner_of(active)
    if obj is None:
        return
    capture = obj.meanvalue.capture
    for number, pair in enumerate(capture.pairs):
        if pair.control == active and capture.active_pair != number:
            capture.active_pair = number


def mesh_of_marker(marker):
    """The mesh object whose take has the Empty `marker`, or None."""
    take = takes.of_marker(marker)
    return None if take is None else mesh_of_take(take)


def mesh_of_take(take):
    """The first mesh object that uses a take, or None."""
    for obj in bpy.context.view_layer.objects:
        if obj.type == 'MESH' and take in {obj.meanvalue.capture.take, obj.meanvalue.capture.reference_take}:
            return obj
    return None


#: Near, middling, far: told apart by most eyes (Okabe and Ito 2008).
SCALE_COLORS = np.array([(0.0, 0.62, 0.45, 1.0), (0.94, 0.89, 0.26, 1.0), (0.84, 0.30, 0.0, 1.0)], np.float32)

#: Distance that has the last color, as a share of the mesh's size: on a person some 12 cm.
FAR = 0.05

ACTIVE_COLOR = (1.0, 1.0, 1.0, 1.0)


def lines(obj):
    """The Lines of a mesh object, where its vertices are to be seen now."""
    capture = obj.meanvalue.capture
    pairs = [pair for pair in capture.pairs if pair.distance >= 0.0 and 0 <= pair.vertex < len(obj.data.vertices)]
    if not pairs:
        return NOTHING
    points = rig_space.shown_positions(obj)[[pair.vertex for pair in pairs]]
    offsets = np.array([pair.offset for pair in pairs], np.float32)
    shares = np.linalg.norm(offsets, axis=1) / max(capture.mesh_size, 1e-30)
    place, stops = np.clip(shares / FAR, 0.0, 1.0) * (len(SCALE_COLORS) - 1), np.arange(len(SCALE_COLORS))
    colors = np.stack([np.interp(place, stops, channel) for channel in SCALE_COLORS.T], axis=1).astype(np.float32)
    active = active_pair(obj)
    colors[[pair == active for pair in pairs]] = ACTIVE_COLOR
    return Lines(np.stack([points, points + offsets], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))


def paint(context, obj):
    if len(obj.meanvalue.capture.pairs):
        draw_lines(context, obj, lines(obj))
