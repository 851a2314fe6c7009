# SPDX-License-Identifier: GPL-3.0-or-later
"""From an object and its settings to the arrays that the solver works on, or to a message why that cannot be."""

import bpy
import numpy as np

from ... import compat, ids
from ...errors import SceneError, require_none
from ...live import roll
from ...scene import declarations, kept, mirrors, object_model, shape_keys, vertex_groups
from ...scene.core import welding, whole_mesh
from ...scene.core.point_sets import require_finite
from ..core.bind_input import BindInput, anchor_layout, soft_border, spring_strengths
from . import controls, examples, limbs, members, orphans, region, targets


def signature(obj):
    """All that is quick to compare of what is read."""
    mesh, settings = obj.data, obj.meanvalue
    of_mesh = obj.name, compat.session_key(mesh), len(mesh.vertices), len(mesh.polygons), mirrors.signature(obj)
    deleted = tuple(handle.name for handle in settings.handles if orphans.is_deleted(handle))
    groups = tuple(obj.vertex_groups.keys())
    return of_mesh, groups, declarations.values(settings), deleted, examples.keys(obj), limbs.signature(obj)


def model(obj):
    """The ObjectModel of what `obj` is posed by."""
    return object_model.of(obj, READING)


def shown(obj):
    """The same for what is drawn: read once after each edit, outside Object Mode as it was read last."""
    found = model(obj)
    if obj.mode == 'OBJECT':
        found.read(obj)
        if roll.follower_of(obj) is None:  # which compares it when all is quiet
            found.compare(obj)
    return found


def member_count(obj, number):
    """How many vertices a handle has; None while that is not known."""
    return len(members.of(obj, [obj.meanvalue.handles[number]])[0]) if model(obj).is_read(obj) else None


def known(obj):
    """The BindInput that was read last, or None."""
    return model(obj).found if obj.meanvalue.handles else None


def gather(obj, to_bind=True):
    """The BindInput of `obj`, checked; to_bind: for the solver, not only for what handles hold. @throws SceneError."""
    if kept.has_any():
        bpy.context.view_layer.update()  # Blender has told of all edits then
    return read(obj, to_bind)


def read(obj, to_bind=True):
    """As gather(), where Blender has told of all edits."""
    require_none(unheld_problem(obj))
    settings, handles = obj.meanvalue, targets.enabled_handles(obj)
    for handle in handles:
        members.require_listed(obj, handle)
    if settings.roi_group:
        vertex_groups.require(obj, settings.roi_group, "the region", "Choose another group or clear the field")
    faces = kept.faces(obj.data)
    corners, starts = faces
    groups = {each.name for each in settings.handles if not each.mark} | {each.group for each in examples.keys(obj)}
    of_limbs = limbs.groups(obj) if settings.method == ids.METHOD_FAST else ()
    vertex_groups.read(obj, groups | {settings.roi_group, *of_limbs})  # in one pass
    held, freedom = members.of(obj, handles), region.known_weights(obj, 1.0)
    _require_members(handles, held, settings.roi_group, freedom)
    anchors, handle_numbers = anchor_layout(held)
    rest = shape_keys.rest_positions(obj.data)
    require_finite(rest, "rest shape")
    planes, twins = mirrors.seams(obj, rest, corners, starts)
    copies = kept.copies(obj, rest)
    freedom = effective_region(freedom, copies, None if twins is None else twins[-1])
    roi = freedom > 0.0
    planes, twins = whole_mesh.needed(planes, twins, roi, anchors)
    rigidity = settings.rigidity if settings.method == ids.METHOD_FAST else None
    border, border_strengths = (None, None) if rigidity is None else soft_border(freedom, anchors, rigidity)
    soft = [handle.strength if handle.is_soft else None for handle in handles]
    if rigidity is None and any(handle.is_soft for handle in handles):
        raise SceneError("Soft handles need the method Fast. Choose it in Solver, or turn Soft off for all handles")
    bind_input = BindInput(
        rest=rest,
        face_corners=corners,
        face_starts=starts,
        anchors=anchors,
        roi=roi,
        method=settings.method,
        handles=handle_numbers,
        rigidity=rigidity,
        **({} if rigidity is None else limbs.read(obj, rest, *faces)),
        strengths=spring_strengths(handle_numbers, soft, rigidity, int(roi.sum())),
        planes=planes,
        twins=twins,
        border=border,
        border_strengths=border_strengths,
        loose=settings.loose_parts,
        copies=copies,
        examples=examples.shown_by(obj) if to_bind else None,
    )
    if to_bind:
        welding.require_no_more_than_seams(rest, corners, starts, settings.merge_distance)
        bind_input.check()
    return bind_input


def _shapes(bind_input):
    found = {}
    for each in (bind_input.examples, bind_input.kept_poses):
        found.update({} if each is None else each.points)
    return [("", bind_input.rest), *found.items()]


READING = object_model.Kind(signature, read, _shapes, shape_keys.result)


def effective_region(freedom, copies, partners):
    """Of n weights of the region those that count: the same for all copies of a merged vertex, and on both sides of a
    symmetric mesh. copies: as of a BindInput; partners: of all vertices, as of mirrors.partners()."""
    freedom = welding.spread(freedom, copies)
    is_symmetric = partners is not None and (partners >= 0).all()
    return welding.spread(np.maximum(freedom, freedom[partners]) if is_symmetric else freedom, copies)


def unheld_problem(obj):
    """Why there is nothing to pose by, in words, or None. Cheap enough for drawing."""
    if all(orphans.is_deleted(handle) for handle in obj.meanvalue.handles):
        return controls.NO_HANDLES
    if not targets.enabled_handles(obj):
        return "All handles are turned off. Tick at least one in the list"
    return None


def _require_members(handles, held, region_name, freedom):
    empty = next((handle for handle, vertices in zip(handles, held, strict=True) if len(vertices) == 0), None)
    if empty is not None:
        why = "left. Remove it" if empty.mark else "with a weight above zero. Assign some, or remove it"
        raise SceneError(f"Handle '{empty.name}' has no vertices {why}")
    if region_name and not (freedom > 0.0).any():
        raise SceneError(f"The region is empty. Assign what may move to '{region_name}', or clear the field")
