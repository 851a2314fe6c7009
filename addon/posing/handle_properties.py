# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of a handle or a pin: `object.meanvalue.handles`."""

import bpy
import numpy as np
from bpy import props

from .. import ids
from ..errors import SceneError
from ..live import engine
from ..scene import vertex_groups
from ..scene.declarations import aside, tell
from .bridge import controls

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)


def _choose_name(handle, context):
    """Of a handle with a group, the artist's own now: as of a region, see properties.py. Others are called uniquely."""
    if handle.name != handle.made_group:
        handle.made_group = ""
    names = [each.name for each in handle.id_data.meanvalue.handles if each != handle]
    if handle.mark and (handle.name in names or not handle.name):
        handle.name = vertex_groups.unused(handle.name or ids.HANDLE_NAME, names)
    tell(handle, context)


def choose_control(handle):
    """A newly chosen control takes the handle over where it is: the pose stays, and Remove leaves the control alone."""
    controls.forget_moved_meshes()
    if (handle.attached, handle.attached_bone) == (handle.control, handle.bone):  # whose place at rest is known
        return
    handle.made_control = False
    handle.attached, handle.attached_bone = handle.control, handle.bone
    if handle.control is None:
        return
    try:
        shown = controls.shown_move(handle.id_data, handle)
        with engine.held():  # the handle has no place with this control yet: Live would move the mesh for a moment
            bpy.context.view_layer.update()  # a control that was just made or moved has its place only after this
        controls.attach_where_they_are(handle.id_data, [handle], [shown])
    except (SceneError, np.linalg.LinAlgError):
        handle.rest_relation = np.zeros(16)  # told as a problem of the control wherever it is used
    handle.id_data.update_tag()


def _paint(handle, _context):
    if handle.made_control and handle.control is not None:
        controls.paint(handle.control, handle)


class MEANVALUE_PG_handle(bpy.types.PropertyGroup):
    """Vertices that are anchors: a handle or a pin"""

    name: props.StringProperty(
        name="Name",
        description="Name of the handle. Where it was made of a vertex group, the group whose vertices hold the mesh",
        update=_choose_name,
    )
    mark: props.IntProperty(options={'HIDDEN'})  # of its vertices, see bridge/members.py; 0: it has a vertex group's
    is_enabled: props.BoolProperty(
        name="Enabled",
        description="Let these vertices hold and pose the mesh. Off, they move like all others",
        default=True,
        update=tell,
    )
    follows: props.EnumProperty(
        name="Follows",
        description="What these vertices follow",
        items=(
            ('CONTROL', "Control", "An object or a bone: move, turn or scale it", 'EMPTY_AXIS', 1),
            ('REST', "Nothing", "A pin: the vertices stay where the rest shape has them", 'PINNED', 2),
        ),
        update=tell,
    )
    control: aside(props.PointerProperty)(
        name="Control",
        description="Object that these vertices follow when it is moved, turned or scaled",
        type=bpy.types.Object,
        poll=lambda handle, candidate: candidate != handle.id_data,
        update=lambda handle, _context: choose_control(handle),
    )
    bone: aside(props.StringProperty)(
        name="Bone",
        description="Bone of the armature that these vertices follow",
        update=lambda handle, _context: choose_control(handle),
    )
    rest_relation: aside(props.FloatVectorProperty)(
        description="Control relative to the object where the vertices are in the rest shape, row by row",
        size=16,
        default=IDENTITY,
        options={'HIDDEN'},
    )
    attached: aside(props.PointerProperty)(type=bpy.types.Object, options={'HIDDEN'})  # whose place at rest is known
    attached_bone: aside(props.StringProperty)(options={'HIDDEN'})
    control_frame: aside(props.FloatVectorProperty)(
        description="What takes the object's uneven scale out where the control stands, row by row",
        size=9,
        default=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        options={'HIDDEN'},
    )
    control_carried: aside(props.FloatVectorProperty)(
        description="The parent inverse that the add-on gave to the control, row by row, to stand where it is seen",
        size=16,
        default=IDENTITY,
        options={'HIDDEN'},
    )
    is_soft: props.BoolProperty(
        name="Soft",
        description="Pull the vertices towards their place by springs instead of putting them there",
        update=tell,
    )
    strength: props.FloatProperty(
        name="Strength",
        description="How hard a soft handle pulls: at 0 hardly at all, at 1 nearly as if it were not soft",
        default=0.5,
        min=0.0,
        max=1.0,
        subtype='FACTOR',
        update=tell,
    )
    size: aside(props.FloatProperty)(
        description="How far its surroundings follow, as a share of the mesh's size; 0 if they were not made by size",
        options={'HIDDEN'},
    )
    color: aside(props.FloatVectorProperty)(
        name="Color",
        description="Color of the handle in the overlay, and of its control",
        subtype='COLOR_GAMMA',  # points are drawn in it as it is
        size=3,
        min=0.0,
        max=1.0,
        default=(1.0, 0.55, 0.1),
        update=_paint,
    )
    made_group: aside(props.StringProperty)(options={'HIDDEN'})  # that an older version made: Remove takes it away
    made_control: aside(props.BoolProperty)(options={'HIDDEN'})
    is_pin: aside(props.BoolProperty)(options={'HIDDEN'})  # pinned where it was posed: its control is there to stay
    marker: aside(props.StringProperty)(options={'HIDDEN'})  # Match Markers made it for this marker
    cuff: aside(props.StringProperty)(options={'HIDDEN'})  # Match Markers made it for this ring of skin
