# SPDX-License-Identifier: GPL-3.0-or-later
"""New handles with a control, and pins; which handle has a vertex; what is called by where it is that nobody named."""

import numpy as np

from ... import ids, wording
from ...errors import SceneError
from ...scene import kept, rig_space, shape_keys, worn
from . import controls, limbs, members, region, targets

PIN_COLOR = (0.0, 0.45, 0.70)


def add_handle(obj, vertices, *, group="", name="", kind=ids.HANDLE_NAME):
    """A new handle, the active one: of the vertex group `group`, or of `vertices`, called `name` or by where it is."""
    settings = obj.meanvalue
    if not group:
        controls.remove_deleted(obj)
    limbs.choose(obj)
    worn.let_go(obj)
    if not settings.handles and not settings.along:
        worn.find(obj)
    handle = settings.handles.add()
    if group:
        handle.name = group
    else:
        members.make(obj, handle, name or named(obj, vertices, kind), vertices)
    settings.active_handle = len(settings.handles) - 1
    return handle


def handle_at(obj, vertex):
    """Number of the first handle that is turned on and has the vertex, or one that is merged with it, or else what is
    below it on clothes; None if none has."""
    first, handles = kept.copies(obj), obj.meanvalue.handles[:]
    held = members.of(obj, handles)
    for pressed in (vertex, region.Surface(obj, [vertex], is_pressed=True).seed) if handles else ():
        copies = [pressed] if first is None else np.flatnonzero(first == first[pressed])
        for number, handle in enumerate(handles):
            if targets.is_taking_part(handle) and np.isin(copies, held[number]).any():
                return number
    return None


def near_vertices(obj, vertex, size):
    """Indices, int32, of what a handle of that Size holds at `vertex` or, on clothes, below it: what is near over the
    surface, on all layers, and in no other handle. What is worn there and pieces that lie completely within Size go
    along without being held."""
    surface = region.Surface(obj, [vertex], is_pressed=True)
    below, reach = surface.below(), size * surface.diagonal
    surface.reach_through(region.HANDLE_SHARE * reach)
    distances = surface.distances(reach, region.HANDLE_SHARE)
    near = np.flatnonzero((distances >= 0.0) & (distances <= region.HANDLE_SHARE * reach)).astype(np.int32)
    held = np.concatenate([np.empty(0, np.int32), *members.of(obj, targets.enabled_handles(obj))])
    near = near[(near == surface.seed) | ~np.isin(near, held) & ((below[near] < 0) | (below[surface.seed] >= 0))]
    return limbs.one_piece(obj, near)


def toggle_pin(obj, vertex, size, name=""):
    """Lets go of the pin `name`, or of the one that has the vertex, or pins the mesh there: Grab with Shift.

    The pin holds as much as a new handle of that size. Returns a message. @throws SceneError.
    """
    index = obj.meanvalue.handles.find(name)
    index = handle_at(obj, vertex) if index < 0 else index
    if index is not None:
        handle = obj.meanvalue.handles[index]
        if handle.follows != 'REST' and not handle.is_pin:
            raise SceneError(f"'{handle.name}' is a handle, which holds like a pin. To remove it, press - in the list")
        name = handle.name
        controls.remove_handle(obj, index)
        return f"Pin '{name}' is let go"
    vertices = near_vertices(obj, vertex, size)
    rest, posed = shape_keys.rest_positions(obj.data), shape_keys.posed_positions(obj)
    moves = 0.0 if posed is None else np.abs(posed - rest)[vertices].max(initial=0.0)
    is_posed = moves > 1e-5 * region.shown_size(obj)
    if is_posed:
        rig_space.measure(obj)  # throws before anything is changed
    handle = add_handle(obj, vertices, kind=ids.PIN_NAME)
    if is_posed:
        controls.add_control(obj, handle, vertices, PIN_COLOR)
        handle.is_pin = True
    else:
        handle.follows, handle.color = 'REST', PIN_COLOR
    obj.update_tag()
    return f"Pin '{handle.name}' holds {wording.vertices(len(vertices))}; Shift-click it again to let go"


#: Of the mesh's size: what is nearer to the middle is on neither side.
MIDDLE = 0.02


def named_pose(obj, offsets):
    """Of what n x 3 `offsets` move at least half as far as any: "Hand.L Pose"."""
    squares = np.square(offsets).sum(axis=1)
    return named(obj, np.flatnonzero(squares >= 0.25 * squares.max()), "Pose")


def named(obj, vertices, kind):
    """Of a `kind` of thing that has these vertices: "Hand.L Handle", "Left Pin"."""
    settings, across = obj.meanvalue, shape_keys.rest_positions(obj.data)[vertices, 0].mean()
    made = {settings.made_region, settings.roi_group, *(handle.made_group for handle in settings.handles)}
    weights = {name: each for name, each in limbs.shares(obj, vertices).items() if each > 0.0 and name not in made}
    is_aside = abs(across) > MIDDLE * np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0))
    side = ("Left" if across > 0.0 else "Right") if is_aside else ""
    return f"{limbs.most_of(obj, weights) or max(weights, key=weights.get, default=side)} {kind}".strip()
