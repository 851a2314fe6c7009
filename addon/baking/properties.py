# SPDX-License-Identifier: GPL-3.0-or-later
"""How an object is baked: `object.meanvalue.bake`."""

import types

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .. import compat
from ..scene.baked import TO_BONES, TO_CACHE, TO_KEYS
from ..scene.declarations import aside

#: What can be chosen, for the settings and for the operator's own properties alike.
OPTIONS = {
    "target": EnumProperty(
        name="Bake to",
        description="What the animation becomes",
        items=(
            (TO_CACHE, "Point Cache", "A file (PC2) that a Mesh Cache modifier plays. For takes of any length"),
            (TO_KEYS, "Shape Keys", "Keys in the mesh, with animated values. For short takes, to go on working on"),
            (TO_BONES, "Armature", "Bones and weights, as game engines want them, of whatever moves the mesh"),
        ),
    ),
    "frame_range": EnumProperty(
        name="Range",
        description="Frames to bake",
        items=(
            ('ANIMATION', "Animation", "From the first to the last keyframe of the controls in the scene's range"),
            ('SCENE', "Scene", "From the scene's first frame to its last"),
            ('OWN', "Own", "From Start to End"),
        ),
    ),
    "frame_start": IntProperty(name="Start", description="First frame to bake", default=1),
    "frame_end": IntProperty(name="End", description="Last frame to bake", default=250),
    "samples": IntProperty(
        name="Samples",
        description="Samples per frame: more than 1 bakes between frames too, for motion blur and fast motion",
        default=1,
        min=1,
        soft_max=8,
        max=100,
    ),
    "path": StringProperty(
        name="File",
        description="Point cache to write. Left empty, it is in the folder meanvalue_cache beside the .blend",
        subtype='FILE_PATH',
        options=compat.flags_of_paths(),
    ),
    "tolerance_share": FloatProperty(
        name="Tolerance",
        description="How far keys (bones: rms) may be off, as a part of the mesh's size; at 0 each sample has a key",
        default=0.1,
        min=0.0,
        soft_max=5.0,
        max=100.0,
        precision=3,
        subtype='PERCENTAGE',
    ),
    "bones": IntProperty(name="Bones", description="How many. 0: as Tolerance takes", default=20, min=0, max=256),
    "influences": IntProperty(name="Influences", description="Most bones of a vertex", default=4, min=1, max=8),
    "skeleton": BoolProperty(name="Skeleton", description="Bones turn about joints. Off: each is free", default=True),
    "its_motion": BoolProperty(name="Its Motion", description="The copy moves as it does: weights alone are fitted"),
    "root_bone": BoolProperty(name="Root Bone", description="One more at the origin carries the walk on the ground"),
}


class MEANVALUE_PG_bake(bpy.types.PropertyGroup):
    """How the object is baked"""

    #: mark: what the markers of its caches have, to be told from others of the same names.
    __annotations__ = {
        **OPTIONS,
        "mark": StringProperty(options={'HIDDEN'}),
        "armature": PointerProperty(
            name="Use Armature",
            description="A copy of it plays, of the same rest pose and names. None: bones are found",
            type=bpy.types.Object,
            poll=lambda _settings, obj: obj.type == 'ARMATURE',
        ),
    }


def chosen(operator, settings, options):
    """The values of OPTIONS or the like: what is set of the operator's own properties, and else the settings."""
    is_set = operator.properties.is_property_set
    return types.SimpleNamespace(**{name: getattr(operator if is_set(name) else settings, name) for name in options})


SETTINGS = {"bake": aside(PointerProperty)(type=MEANVALUE_PG_bake)}
