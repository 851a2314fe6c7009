# SPDX-License-Identifier: GPL-3.0-or-later
"""The soft handles that carry a mesh after the markers of a take, one vertex each, and their animated controls."""

import bpy
import numpy as np

from ...posing.bridge import controls
from ...scene import actions, vertex_groups
from ...scene.core import sample_times
from . import marker_pairs

#: Size of a control, as a share of the mesh's bounding-box diagonal.
CONTROL_SIZE = 0.006

COLOR = (0.34, 0.71, 0.91)

#: Motion capture is noisy, yet more to be trusted than the rest shape.
STRENGTH = 1.0


def update_handles(obj, matched):
    """Handles for every marker that was matched (bridge.marker_matching.Matched), and for no other."""
    capture = obj.meanvalue.capture
    for pair in capture.pairs:
        if pair.name not in matched.names:
            drop(obj, pair)
            if not pair.is_picked:
                pair.vertex = -1
            pair.distance = -1.0
    marker_pairs.list_markers(capture)
    capture.alignment = matched.alignment.ravel()
    capture.mesh_size = matched.size
    capture.reference_frame = matched.frame
    for number in range(len(matched.names)):
        update_handle(obj, matched, number)


def update_handle(obj, matched, number):
    """Has a handle move the vertex of a matched marker to its targets; where they are NaN, the handle is free.

    The handle that the marker has is used again, with what the artist set on it; else one is made.
    """
    name, vertex = matched.names[number], int(matched.vertices[number])
    pair = obj.meanvalue.capture.pairs[name]
    handle = marker_pairs.handle_of(obj, pair) or make_soft_handle(obj, name, COLOR)
    handle.marker = name
    control = control_of(obj, handle, name, 'CUBE', CONTROL_SIZE * matched.size)
    at_rest = np.eye(4)
    at_rest[:3, 3] = matched.rest[number]
    controls.choose(handle, control, at_rest)
    give_members(obj, handle, np.array([vertex]))
    pair.vertex = vertex
    pair.offset, pair.distance = matched.offsets[number], matched.distance[number]
    _animate(control, matched.targets[:, number], matched.frames, matched.rest[number], matched.ramp)


def drop(obj, pair):
    """Takes away what was made for a pair, which stays on the list."""
    index = marker_pairs.handle_index(obj, pair)
    if index is not None:
        controls.remove_handle(obj, index)
    _remove_if_empty(obj)


def make_soft_handle(obj, name, color):
    """A soft handle that follows a control, with a vertex group of its own."""
    handle = obj.meanvalue.handles.add()
    handle.name = vertex_groups.make(obj, name).name
    handle.made_group = True
    handle.color = color
    handle.follows = 'CONTROL'
    handle.is_soft = True
    handle.strength = STRENGTH
    return handle


def give_members(obj, handle, vertices):
    """Has the handle hold these vertices, and no other. Its group is made again where the artist took it away."""
    if handle.name not in obj.vertex_groups:
        handle.name = vertex_groups.make(obj, handle.marker or handle.cuff).name
        handle.made_group = True  # after naming one, which says that it is the artist's
    vertex_groups.replace_members(obj, obj.vertex_groups[handle.name], vertices)


def control_of(obj, handle, name, shape, size):
    """The control of a handle, or a new one: the first, or for one that was deleted or is the original's."""
    control = handle.control
    if control is not None and control.users_scene and controls.owner_of(control) == obj:
        return control
    return _make_control(obj, handle, name, shape, size)


def _make_control(obj, handle, name, shape, size):
    """A child of the object, as all controls, so that moving the object moves the whole character."""
    control = bpy.data.objects.new(f"{obj.name} {name}", None)
    _collection(obj).objects.link(control)
    control.empty_display_type = shape
    control.empty_display_size = size
    control.show_in_front = True
    controls.paint(control, handle)
    control.parent = obj
    return control


def write_influence(control, present, frames, ramp):
    """Keys the influence of a control: 0 where its markers are away, fading over `ramp` samples before and after."""
    keyed, values = sample_times.changing_keys(sample_times.ramps(present, ramp), frames)
    actions.write_curve(control, "meanvalue.influence", 0, keyed, values)
    if len(keyed) == 0:
        control.meanvalue.influence = 1.0


def _animate(control, targets, frames, rest, ramp):
    present = ~np.isnan(targets).any(axis=1)
    actions.write_vector(control, "location", frames[present], targets[present])
    write_influence(control, present, frames, ramp)
    control.location = targets[int(present.argmax())] if present.any() else rest


def _collection(obj):
    """The collection of the object's marker controls; made if it is missing."""
    capture = obj.meanvalue.capture
    if capture.controls is None:
        capture.controls = bpy.data.collections.new(f"{obj.name} Markers")
    parent = obj.users_collection[0] if obj.users_collection else bpy.context.scene.collection
    if not any(capture.controls.name in other.children for other in (*bpy.data.collections, *_roots())):
        parent.children.link(capture.controls)
    return capture.controls


def _roots():
    return [scene.collection for scene in bpy.data.scenes]


def _remove_if_empty(obj):
    collection = obj.meanvalue.capture.controls
    if collection is not None and not collection.objects and not collection.children:
        bpy.data.collections.remove(collection)
