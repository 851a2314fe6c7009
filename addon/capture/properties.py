# SPDX-License-Identifier: GPL-3.0-or-later
"""What is kept of motion capture: `collection.meanvalue` of a take, `object.meanvalue.capture` of a mesh."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from ..posing.properties import IDENTITY
from ..scene.declarations import aside
from .bridge import marker_pairs, match_input, takes


class MEANVALUE_PG_marker_problem(bpy.types.PropertyGroup):
    """Something about a marker that the artist should look at"""

    text: StringProperty()
    marker: PointerProperty(type=bpy.types.Object)
    other: PointerProperty(type=bpy.types.Object, description="The marker that it was swapped with")
    frame: FloatProperty()


class MEANVALUE_PG_take(bpy.types.PropertyGroup):
    """What a collection of markers was recorded as"""

    is_take: BoolProperty(options={'HIDDEN'})
    is_skeleton: BoolProperty(description="The markers are joints of a skeleton, as in BVH", options={'HIDDEN'})
    rate_hz: FloatProperty(name="Rate", description="Samples a second, as recorded")
    sample_count: IntProperty(name="Samples")
    frames_per_sample: FloatProperty(description="Frames of the scene from one sample to the next")
    fullest_frame: FloatProperty(description="First frame of the scene in which the most markers are seen")
    missing_share: FloatProperty(description="Share of samples in which a marker was not seen")
    problems: CollectionProperty(type=MEANVALUE_PG_marker_problem)
    active_problem: IntProperty(
        name="Active Problem", default=-1, min=-1, update=lambda take, _context: takes.go_to_problem(take.id_data)
    )
    is_searched: BoolProperty(description="Problems were looked for")


class MEANVALUE_PG_marker_pair(bpy.types.PropertyGroup):
    """A marker and its point on the mesh; its name is the marker's"""

    is_used: BoolProperty(
        name="Use", description="Let Match Markers give this marker a handle. Off, the marker is left out", default=True
    )
    vertex: IntProperty(description="Vertex that the marker carries, -1 for none", default=-1, min=-1)
    landmark: StringProperty(
        name="Landmark",
        description="Place of the body that the marker is on, such as knee.L. Empty: as its name says",
        search=lambda _pair, _context, text: [name for name in match_input.candidates() if text.lower() in name],
    )
    is_picked: BoolProperty(
        name="Picked", description="The point was picked by hand: Match Markers keeps it, and may align by it"
    )
    offset: FloatVectorProperty(
        description="From the vertex to the aligned marker at the reference frame, in the object's space", size=3
    )
    distance: FloatProperty(
        name="Distance",
        description="From the aligned marker at the reference frame to its point on the mesh",
        subtype='DISTANCE',
        default=-1.0,
    )

    @property
    def control(self):
        """The control of the handle that Match Markers made, or None."""
        handle = marker_pairs.handle_of(self.id_data, self)
        return handle.control if handle is not None else None


class MEANVALUE_PG_capture(bpy.types.PropertyGroup):
    """How a mesh follows a take"""

    take: PointerProperty(
        name="Take",
        description="The imported markers that move the mesh",
        type=bpy.types.Collection,
        poll=lambda _capture, collection: takes.is_take(collection),
        update=marker_pairs.begin_with_take,
    )
    reference_take: PointerProperty(
        name="Reference Take",
        description="A take of the same markers in which the person stands as the mesh does, such as a static trial",
        type=bpy.types.Collection,
        poll=lambda _capture, collection: takes.is_take(collection),
        update=marker_pairs.begin_with_take,
    )
    reference_frame: FloatProperty(
        name="Reference Frame",
        description="Frame of the scene in which the markers stand as the mesh does at rest",
        default=1.0,
        precision=2,
    )
    align: EnumProperty(
        name="Align",
        description="How the markers of the reference frame are laid on the mesh",
        items=(
            ('AUTO', "Automatic", "By the shape of the markers and of the mesh"),
            ('PICKED', "Picked Pairs", "By three or more markers whose points on the mesh were picked"),
            ('NONE', "In Place", "The markers are where they belong already, or their parents put them there"),
        ),
        default='AUTO',
    )
    pose_limbs: BoolProperty(
        name="Pose Limbs",
        description="Turn arms and legs of the reference to where the mesh has them, if the person stands otherwise",
        default=True,
    )
    keep_floor: BoolProperty(name="Soles on the Floor", description="Feet stand on it, and toes bend", default=True)
    floor_height: FloatProperty(name="Floor Height", description="Above the mesh's lowest point", unit='LENGTH')
    alignment: FloatVectorProperty(
        description="From the world of the markers to the mesh's own space, row by row, as last matched",
        size=16,
        default=IDENTITY,
        options={'HIDDEN'},
    )
    mesh_size: FloatProperty(description="Bounding-box diagonal of the mesh that was matched", options={'HIDDEN'})
    rigid_seconds: FloatProperty(
        name="Fill Gaps",
        description="Gaps up to this long are filled as the marker and its neighbors move; longer ones free the handle",
        default=1.0,
        min=0.0,
        soft_max=5.0,
        unit='TIME_ABSOLUTE',
    )
    use_low_pass: BoolProperty(
        name="Low-Pass", description="Smooth the paths of the markers by a zero-lag Butterworth filter"
    )
    cutoff_hz: FloatProperty(
        name="Cut-off (Hz)",
        description="Motion faster than this is taken for noise. 6 Hz suits walking, 10 to 15 Hz running and blows",
        default=6.0,
        min=0.1,
        soft_max=30.0,
    )
    mode: EnumProperty(
        name="Lengths",
        description="What to do where the character is not built as the person was",
        items=(
            ('AS_CAPTURED', "As Captured", "The paths of the markers, at one scale"),
            ('RETARGET', "Retarget", "The directions of the capture with the lengths of the character"),
        ),
        default='AS_CAPTURED',
    )
    pairs: CollectionProperty(type=MEANVALUE_PG_marker_pair)
    active_pair: IntProperty(
        name="Active Marker", min=0, update=lambda capture, _context: marker_pairs.select_active(capture.id_data)
    )


SETTINGS = {
    "marker": aside(StringProperty)(options={'HIDDEN'}),  # of a marker of a take: its name in the file
    "capture": aside(PointerProperty)(type=MEANVALUE_PG_capture),
}
