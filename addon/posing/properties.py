# SPDX-License-Identifier: GPL-3.0-or-later
"""What posing keeps on an object, in `object.meanvalue`."""

import bpy
import numpy as np
from bpy import props

from .. import ids
from ..errors import SceneError
from ..live import engine
from ..scene import along, key_marks, vertex_groups, worn
from ..scene.declarations import aside, tell
from .bridge import controls
from .live import follower

IDENTITY = tuple(np.eye(4).ravel())


def _choose_name(handle, context):
    """Of a handle with a group, the artist's own now: as of a region. Others are called uniquely."""
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


def _color(handle, _context):
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
    #: 4 x 4, row by row: the control relative to the object where the vertices are in the rest shape.
    rest_relation: aside(props.FloatVectorProperty)(size=16, default=IDENTITY, options={'HIDDEN'})
    attached: aside(props.PointerProperty)(type=bpy.types.Object, options={'HIDDEN'})  # whose place at rest is known
    attached_bone: aside(props.StringProperty)(options={'HIDDEN'})
    #: 3 x 3: takes the object's uneven scale out where the control stands.
    control_frame: aside(props.FloatVectorProperty)(size=9, default=tuple(np.eye(3).ravel()), options={'HIDDEN'})
    #: 4 x 4: the parent inverse that the add-on gave to the control, to stand where it is seen.
    control_carried: aside(props.FloatVectorProperty)(size=16, default=IDENTITY, options={'HIDDEN'})
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
    size: aside(props.FloatProperty)(options={'HIDDEN'})  # a share of the mesh's; 0: surroundings were not made by it
    color: aside(props.FloatVectorProperty)(
        name="Color",
        description="Color of the handle in the overlay, and of its control",
        subtype='COLOR_GAMMA',  # points are drawn in it as it is
        size=3,
        min=0.0,
        max=1.0,
        default=(1.0, 0.55, 0.1),
        update=_color,
    )
    made_group: aside(props.StringProperty)(options={'HIDDEN'})  # that an older version made: Remove takes it away
    made_control: aside(props.BoolProperty)(options={'HIDDEN'})
    is_pin: aside(props.BoolProperty)(options={'HIDDEN'})  # pinned where it was posed: its control is there to stay
    marker: aside(props.StringProperty)(options={'HIDDEN'})  # Match Markers made it for this marker
    cuff: aside(props.StringProperty)(options={'HIDDEN'})  # Match Markers made it for this ring of skin


class MEANVALUE_PG_bound_record(bpy.types.PropertyGroup):
    """What the mesh was bound as, see posing/bridge/scene_input.py: a count for messages, and digests"""

    is_bound: props.BoolProperty()
    vertex_count: props.IntProperty()
    faces: props.StringProperty()
    rest_shape: props.StringProperty()


def _choose_region(settings, context):
    """A group that the artist chose is not the add-on's to delete, though the add-on may have made it once."""
    if settings.roi_group != settings.made_region:
        settings.made_region = ""
    tell(settings, context)


def _paint(settings, context):
    if settings.stiffness_group:
        settings.bend_at = ids.BEND_PAINTED
    tell(settings, context)


def _tick(line, context):
    other = line.object
    worn.forget()
    if other is not None and not line.is_taken and worn.problem(line.id_data, other) is None:
        along.remove_pose(other)
    tell(line, context)


class MEANVALUE_PG_along(bpy.types.PropertyGroup):
    """An object that goes along with the mesh when it is posed"""

    object: props.PointerProperty(type=bpy.types.Object)
    is_taken: props.BoolProperty(
        name="Goes Along", description="Have this object go along when the mesh is posed", default=True, update=_tick
    )
    kind: props.EnumProperty(
        name="Kind",
        description="How the object goes along",
        items=(
            ('AUTO', "Automatic", "Small parts are rigid, and what is far from the surface; all else is cloth"),
            ('CLOTH', "Cloth", "It bends with the surface below it"),
            ('RIGID', "Rigid", "Each part keeps its shape"),
        ),
        update=tell,
    )


class Settings:
    """Annotations for the property group of an object, see registration.py"""

    handles: props.CollectionProperty(type=MEANVALUE_PG_handle)
    active_handle: aside(props.IntProperty)(name="Active Handle", min=0)
    live: aside(props.BoolProperty)(
        name="Live",
        description="Pose the mesh at once whenever a handle or a setting changes",
        update=lambda settings, _context: follower.turned(settings.id_data),
    )
    roi_group: props.StringProperty(
        name="Region",
        description="Vertex group of the vertices that may move; weights are a falloff. Without a group, all may move",
        update=_choose_region,
    )
    symmetric: props.EnumProperty(
        name="Symmetric",
        description="Do what a handle does mirrored on the other side, too. For meshes that are the same on both sides",
        items=(
            ('NONE', "Off", "Handles move what they hold"),
            ('X', "X", "The left and the right side are mirrored"),
            ('Y', "Y", "The front and the back are mirrored"),
            ('Z', "Z", "Top and bottom are mirrored"),
        ),
        update=tell,
    )
    method: props.EnumProperty(
        name="Method",
        description="How the shape is found",
        items=(
            (ids.METHOD_FAST, "Fast", "Keeps shape and lengths, follows far turns, quick enough to drag"),
            (ids.METHOD_PAPER, "Paper", "The hierarchical decoding of Kraevoy and Sheffer"),
            (ids.METHOD_FULL, "Full", "The paper's energy minimized over the whole mesh at once. Slow on big meshes"),
        ),
        update=tell,
    )
    rigidity: props.FloatProperty(
        name="Rigidity",
        description="From soft (0 to 5: parts grow and shrink freely) to stiff (100: parts keep their lengths)",
        default=ids.DEFAULT_RIGIDITY,
        min=0.0,
        soft_max=100.0,
        max=1e6,
        update=tell,
    )
    bend_at: props.EnumProperty(
        name="Bend At",
        description="Where limbs are stiff, and where they bend",
        items=(
            (ids.BEND_EVERYWHERE, "Everywhere", "The mesh bends and stretches alike everywhere"),
            (ids.BEND_RIG, "Rig's Joints", "Limbs keep their lengths, and bend where the weights of bones meet"),
            (ids.BEND_POSES, "Kept Poses", "It bends where kept poses do: keep two or more that bend all joints"),
            (ids.BEND_PAINTED, "Painted", "What a vertex group has bends and stretches less"),
        ),
        update=tell,
    )
    show_joints: aside(props.BoolProperty)(
        name="Show Joints", description="Tint the mesh where it bends in place of the region", update=tell
    )
    stretch: aside(props.BoolProperty)(
        name="Stretch", description="Let limbs stretch to where handles are, however far that is", update=tell
    )
    stiffness_group: props.StringProperty(
        name="Limbs", description="Vertex group of limbs, without their joints", update=_paint
    )
    pose_like: props.EnumProperty(
        name="Pose Like",
        description="What shows how the mesh bends",
        items=(
            (ids.LIKE_NOTHING, "Nothing", "The mesh keeps its shape as well as it can"),
            (ids.LIKE_KEYS, "Own Shape Keys", "It bends as its own shape keys at value 1 do, if they are not muted"),
            (ids.LIKE_RIG, "Own Rig", "It bends as its rig does in the poses that Sample Rig Poses keeps"),
        ),
        update=tell,
    )
    loose_parts: props.EnumProperty(
        name="Loose Parts",
        description="What becomes of parts that no handle and no pin holds, such as eyes, teeth and buttons",
        items=(
            (ids.LOOSE_FOLLOW, "Follow", "They go along with the nearest surface that is held. Clothes bend with it"),
            (ids.LOOSE_STAY, "Stay", "They keep their place"),
        ),
        update=tell,
    )
    close_seams: props.BoolProperty(
        name="Close Seams",
        description="Vertices of open borders in one place move as one, as where a texture or a sharp edge splits them",
        default=True,
        update=tell,
    )
    merge_distance: props.FloatProperty(
        name="Merge Distance",
        description="Vertices this near to each other move as one too: closes seams that gape, and joins layers",
        min=0.0,
        soft_max=0.01,
        precision=5,
        step=0.01,
        subtype='DISTANCE',
        update=tell,
    )
    result_key: props.StringProperty(
        name="Result",
        description="Shape key that Solve and Live write, made if it is missing",
        get=key_marks.get_name,
        set=key_marks.choose,
        update=tell,
    )
    result_name: aside(props.StringProperty)(default=ids.DEFAULT_RESULT_KEY, options={'HIDDEN'})  # as it was last
    result_mark: aside(props.FloatProperty)(options={'HIDDEN'})  # of the result's shape key, see scene/key_marks.py
    made_region: aside(props.StringProperty)(options={'HIDDEN'})  # the vertex group that was made for a region
    show_overlay: aside(props.BoolProperty)(
        name="Overlay", description="Show handles, pins and region in the 3D View", default=True
    )
    version: aside(props.IntProperty)(options={'HIDDEN'})  # of these settings when it was bound, see old_files.py
    along: aside(props.CollectionProperty)(type=MEANVALUE_PG_along)  # see scene/worn.py
    active_along: aside(props.IntProperty)(name="Active Object", min=0)
    bound: aside(props.PointerProperty)(type=MEANVALUE_PG_bound_record)
    is_control: aside(props.BoolProperty)(options={'HIDDEN'})  # an Empty that the add-on made, see bridge/orphans.py
    influence: aside(props.FloatProperty)(  # of a control: how much its soft handle counts, 0 in gaps of a capture
        name="Influence", default=1.0, min=0.0, max=1.0, update=tell
    )
