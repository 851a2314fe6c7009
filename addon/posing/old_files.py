# SPDX-License-Identifier: GPL-3.0-or-later
"""What older files have otherwise: carried over when they are opened, and when their objects are appended. In version
0.1.0 handles were `object.meanvalue.anchor_groups`; a region had Invert, with which those outside the group may move;
seams were open, and the result was known by its name. To be deleted once nobody has such files."""

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, IntProperty, StringProperty

from .. import ids, wording
from ..scene import kept, mirrors, pose_key, shape_keys, views
from ..scene.declarations import aside
from .bridge import control_places, controls, region, scene_input
from .handle_properties import MEANVALUE_PG_handle

#: What controls.choose() sets, and what is stored otherwise.
_SET_APART = {"follows", "control", "attached", "attached_bone", "rest_relation", "made_control", "made_group"}


class MEANVALUE_PG_anchor_group(bpy.types.PropertyGroup):
    """A handle as version 0.1.0 stored it"""

    __annotations__ = {
        **MEANVALUE_PG_handle.__annotations__,
        "follows": EnumProperty(
            items=(('SHAPE', "", "", 0), ('CONTROL', "", "", 1), ('REST', "", "", 2)), default='SHAPE'
        ),
        "made_group": BoolProperty(options={'HIDDEN'}),
    }


def _turn_region_around(obj):
    """A group of its own takes the place of one that was inverted. In Edit Mode that waits until it is left."""
    settings = obj.meanvalue
    if not settings.roi_invert or obj.type != 'MESH' or obj.mode == 'EDIT' or obj.data.library or obj.override_library:
        return
    rest = shape_keys.rest_positions(obj.data)
    held = scene_input.effective_region(region.weights(obj), kept.copies(obj, rest), mirrors.partners(obj, rest))
    settings.roi_invert = False
    if settings.roi_group in obj.vertex_groups:
        region.write(obj, 1.0 - held)


SETTINGS = {
    "roi_invert": aside(BoolProperty)(
        options={'HIDDEN'}, update=lambda settings, _context: _turn_region_around(settings.id_data)
    ),
    "anchor_groups": aside(CollectionProperty)(type=MEANVALUE_PG_anchor_group, options={'HIDDEN'}),
    "active_anchor_group": aside(IntProperty)(options={'HIDDEN'}),
    "former_result": aside(StringProperty)(options={'HIDDEN'}),  # the shape key that the last solve wrote
}


def carry_over(objects):
    """Makes of what older versions left in the settings of `objects` what there is now."""
    for obj in objects:
        if obj.library is not None:
            continue
        bound = obj.meanvalue.bound
        if bound.is_bound and not bound.knows_seams:
            obj.meanvalue.close_seams, bound.knows_seams = False, True
        if obj.meanvalue.stiffness_group and not obj.meanvalue.is_property_set("bend_at"):
            obj.meanvalue.bend_at = ids.BEND_PAINTED
        if len(obj.meanvalue.anchor_groups):
            _carry_over(obj)
        if obj.meanvalue.roi_invert:
            _turn_region_around(obj)
        _mark_result(obj)


def _mark_result(obj):
    """The shape key that the last solve wrote had its name alone."""
    settings, keys = obj.meanvalue, getattr(obj.data, "shape_keys", None)
    if not settings.former_result or keys is None or keys.library is not None:
        return
    result = keys.key_blocks.get(settings.former_result)
    if result not in {None, keys.reference_key}:
        pose_key.adopt(settings, result)
    settings.former_result = ""


def _carry_over(obj):
    settings = obj.meanvalue
    followed_key = []
    for old in settings.anchor_groups:
        handle = settings.handles.add()
        for name in MEANVALUE_PG_handle.__annotations__:
            if name not in _SET_APART:
                setattr(handle, name, getattr(old, name))
        handle.follows = 'REST' if old.follows == 'SHAPE' else old.follows
        handle.made_group = old.name if old.made_group else ""
        controls.choose(handle, old.control, control_places.at_rest(old), made=old.made_control)
        if old.follows == 'SHAPE':
            followed_key.append(old.name)
    settings.active_handle = settings.active_anchor_group
    settings.anchor_groups.clear()
    settings.property_unset("active_anchor_group")
    if followed_key:
        _tell(obj, followed_key)


def _tell(obj, names):
    pins = "is a pin" if len(names) == 1 else "are pins"
    text = wording.sentence(
        f"{wording.quoted(names)} of '{obj.name}' followed a shape key and {pins} now. To pose by it again, press "
        "Solve from Shape Key"
    )
    views.say(text)
    if not bpy.app.background:
        bpy.app.timers.register(lambda: views.pop_up("Mean-Value", text), first_interval=0.1)
