# SPDX-License-Identifier: GPL-3.0-or-later
"""How values of shape keys are baked: `object.meanvalue.bake_values`; what handles drive: `object.meanvalue.drive`."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty

from ..baking import properties as baking
from ..scene.declarations import aside
from .bridge import driven_keys
from .bridge.head_motion import DROPPED, ON_BONE, ON_OBJECT, STILL

#: What is usual: markers are on a head that moves, handles on one that does not.
USUAL_MOTION = {'HANDLES': STILL, 'MARKERS': ON_OBJECT}


#: What can be chosen, for the settings and for the operator's own properties alike.
OPTIONS = {
    "source": EnumProperty(
        name="From",
        description="What the shape keys are to follow",
        items=(
            ('HANDLES', "Handles", "The animated handles, whatever moves them"),
            (
                'MARKERS',
                "Markers",
                "The take of Motion Capture, laid on the face by picked pairs. Needs no names of markers",
            ),
        ),
        update=lambda options, _context: setattr(options, "head_motion", USUAL_MOTION[options.source]),
    ),
    "head_motion": EnumProperty(
        name="Head Motion",
        description="What becomes of the motion of the whole",
        items=(
            (ON_OBJECT, "On the Object", "Keyframes of the object's location and rotation"),
            (ON_BONE, "On a Bone", "Keyframes of a bone of its armature, which carries the mesh"),
            (DROPPED, "Dropped", "Found, and left out: the head stays where it is"),
            (STILL, "None", "The head stands still, and whatever moves is the face"),
        ),
        default=STILL,
    ),
    "bone": StringProperty(name="Bone", description="Bone that carries the head"),
    "tolerance": FloatProperty(
        name="Tolerance",
        description="As few keyframes are made as keep every value within this; at 0 one for each frame",
        default=0.005,
        min=0.0,
        max=1.0,
        precision=3,
    ),
    "replace": BoolProperty(name="Replace", description="Write over what is animated already"),
    **{name: baking.OPTIONS[name] for name in ("frame_range", "frame_start", "frame_end")},
}


class MEANVALUE_PG_bake_values(bpy.types.PropertyGroup):
    """How values of shape keys are baked"""

    __annotations__ = OPTIONS


SETTINGS = {
    "bake_values": aside(PointerProperty)(type=MEANVALUE_PG_bake_values),
    "drive": aside(EnumProperty)(
        name="Drive",
        description="What follows the handles with Live",
        items=(
            (driven_keys.SHAPE, "Shape", "The mesh itself, in a shape key of its own"),
            (driven_keys.KEYS, "Shape Keys", "The sliders of the shape keys that the mesh has, within their ranges"),
        ),
        update=lambda settings, _context: driven_keys.chosen(settings.id_data),
    ),
}
