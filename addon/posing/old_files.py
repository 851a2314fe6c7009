# SPDX-License-Identifier: GPL-3.0-or-later
"""What older files have otherwise: carried over when they are opened, and when their objects are appended. What was
bound says in `version` how many of MIGRATIONS it does not need any more; all else may go through them again."""

import bpy

from .. import compat, ids, wording
from ..scene import kept, key_marks, mirrors, shape_keys, subject, views
from .bridge import control_places, controls, region, scene_input
from .properties import MEANVALUE_PG_handle

#: What controls.choose() sets, and what is stored otherwise.
_SET_APART = {"follows", "control", "attached", "attached_bone", "rest_relation", "made_control", "made_group"}


def carry_over(*objects):
    """Makes of what older versions left in the settings of `objects`, or of all, what there is now."""
    for obj in objects or bpy.data.objects:
        settings = obj.meanvalue
        to_do = MIGRATIONS[settings.version :] if subject.object_problem(obj) is None else ()
        stored = compat.stored(obj) if to_do else None
        if stored and all(migrate(obj, stored) for migrate in to_do) and settings.bound.is_bound:
            settings.version = len(MIGRATIONS)


def _from_0_1(obj, stored):
    """Of version 0.1.0: handles were `anchor_groups`; a region had Invert, with which those outside the group may move;
    seams were open, and the result was known by its name. Returns whether nothing is left to do."""
    settings = obj.meanvalue
    if stored.get("roi_invert") and obj.mode == 'EDIT':
        return False  # its groups are written when that is left
    if settings.bound.is_bound and not stored["bound"].get("knows_seams", False):
        settings.close_seams = False
    if settings.stiffness_group and not settings.is_property_set("bend_at"):
        settings.bend_at = ids.BEND_PAINTED
    followed_key = [old["name"] for old in stored.get("anchor_groups", ()) if _add_handle(settings, old)]
    if stored.pop("anchor_groups", None):
        settings.active_handle = stored.pop("active_anchor_group", 0)
    if followed_key:
        pins = "is a pin" if len(followed_key) == 1 else "are pins"
        text = wording.sentence(
            f"{wording.quoted(followed_key)} of '{obj.name}' followed a shape key and {pins} now. To pose by it again, "
            "press Solve from Shape Key"
        )
        views.say(text)
        if not bpy.app.background:
            bpy.app.timers.register(lambda: views.pop_up("Mean-Value", text), first_interval=0.1)
    keys, name = obj.data.shape_keys, stored.pop("former_result", "")
    result = keys.key_blocks.get(name) if name and keys is not None else None
    if result is not None and result != keys.reference_key:
        key_marks.adopt(settings, result)
    if stored.pop("roi_invert", False) and settings.roi_group in obj.vertex_groups:
        rest = shape_keys.rest_positions(obj.data)
        held = scene_input.effective_region(region.weights(obj), kept.copies(obj, rest), mirrors.partners(obj, rest))
        region.write(obj, 1.0 - held)  # to a group of its own
    return True


def _gaps_by_a_curve(obj, stored):
    """Of captures: a curve filled gaps up to `spline_seconds`, 0.2 where not stored, whatever `rigid_seconds` said.
    Where nothing was bound, 0 may have been chosen since."""
    capture = stored.get("capture") or {}
    longest = capture.pop("spline_seconds", 0.2 if obj.meanvalue.bound.is_bound else 0.0)
    if longest > capture.get("rigid_seconds", 1.0):
        capture["rigid_seconds"] = longest
    return True


MIGRATIONS = _from_0_1, _gaps_by_a_curve


def _add_handle(settings, old):
    """Returns whether it followed a shape key, and is a pin now."""
    handle = settings.handles.add()
    for name in MEANVALUE_PG_handle.__annotations__:
        if name in old and name not in _SET_APART:
            setattr(handle, name, old[name])
    follows = ('SHAPE', 'CONTROL', 'REST')[old.get("follows", 0)]
    handle.follows = 'REST' if follows == 'SHAPE' else follows
    handle.made_group = old["name"] if old.get("made_group") else ""
    handle.rest_relation = old.get("rest_relation", handle.rest_relation)
    control = old.get("control") if isinstance(old.get("control"), bpy.types.Object) else None  # {} where none was set
    controls.choose(handle, control, control_places.at_rest(handle), made=bool(old.get("made_control")))
    return follows == 'SHAPE'
