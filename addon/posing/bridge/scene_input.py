# SPDX-License-Identifier: GPL-3.0-or-later
"""From an object and its settings to the arrays that the solver works on, or to a message why that cannot be; and the
calls to make with them (Posing). A binding is kept in the .blend as a record, a fingerprint."""

import bpy
import numpy as np

from ... import compat, ids, wording
from ...errors import ChangedMeanwhileError, SceneError, StaleBindingError, require_none
from ...live import roll
from ...scene import declarations, kept, mesh_arrays, mirrors, object_model, shape_keys, subject, vertex_groups
from ...scene.core import welding, whole_mesh
from ...scene.core.point_sets import require_finite
from ...solver import session
from ...solver.core import fingerprint, result
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
        strengths=spring_strengths(handle_numbers, soft, rigidity),
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


#: Of a Posing: the targets are where the controls are.
CONTROLS = ""


class Posing:
    """Arrays of one object; work() binds `bind_input` if there is no `binding`, and solves for `targets`, if any."""

    def __init__(self, obj, goal=None, is_checked=True, settles=False):
        """goal: CONTROLS, or the name of a shape key that has the targets; None to bind only. is_checked: it has to fit
        the binding on record. settles: the answer from rest, unless a rough one from the result that is there is lower.

        @throws SceneError; StaleBindingError if the artist has to look first.
        """
        self.bind_input = gather(obj)
        if is_checked:
            require_fits(obj.meanvalue.bound, self.bind_input.fingerprint)
        self._goal = goal
        self.targets = None if goal is None else targets.gather(obj, self.bind_input, goal)
        self._start = shape_keys.result_positions(obj) if settles else None
        found = self.bind_input.fingerprint
        self.binding = session.cache.get(found)
        self._known = session.cache.relative(found.family) if self.binding is None else None
        is_new = self.binding is None and self._known is None
        shape = self.bind_input.rest, self.bind_input.face_corners
        self._triangles = mesh_arrays.triangles(obj.data, *shape) if is_new else None

    def work(self, execution):
        """Steps (see solver/job.py) to (n x 3 float32, native solution), None if bound. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from session.bind_steps(self.bind_input, self._triangles, execution, known=self._known)
            self._triangles = self._known = None
        if self.targets is None:
            return None
        drag = session.begin_drag(self.binding, self.bind_input, self._start)
        solved, solution = yield from session.solve_steps(drag, self.targets, settle=True, execution=execution)
        return result.compose(self.bind_input, self.targets.positions, solved), solution

    def record(self, obj):
        """Keeps the binding for the session, and tells the file of it."""
        session.remember(self.bind_input, self.binding)
        note_binding(obj.meanvalue.bound, self.bind_input.fingerprint)
        obj.update_tag()  # live posing may have waited for it

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if a script, a timer or another window made the scene another one."""
        problem = subject.object_problem(obj) or subject.mode_problem(obj)
        if problem is None:
            now = gather(obj)
            goal = None if self._goal is None else targets.gather(obj, now, self._goal)
            is_same = now.fingerprint == self.bind_input.fingerprint
            if is_same and (goal is None or goal.is_near(self.targets, 0.0)):
                return
        raise ChangedMeanwhileError(obj.name)


def require_fits(record, now):
    """now: a Fingerprint. @throws StaleBindingError if the artist has to look first: else it is bound again."""
    changes = fingerprint.changes(record, now) if record.is_bound else ""
    if changes:
        raise StaleBindingError(f"{changes}. Check the handles and press Update")


def fit_problem(obj):
    """(why a mesh object cannot be posed by what was read of it, as a sentence; whether Update mends that), or None."""
    model = shown(obj)
    try:
        if model.is_known:
            require_fits(obj.meanvalue.bound, model.result(obj).fingerprint)
    except SceneError as error:
        return wording.sentence(str(error)), isinstance(error, StaleBindingError)
    return None


def note_binding(record, now):
    """Remembers the binding of a Fingerprint: what of it the artist has to look at where it is another."""
    record.vertex_count, record.faces, record.rest_shape = now.vertex_count, now.faces, now.rest_shape
    record.is_bound, record.id_data.meanvalue.version = True, ids.SETTINGS_VERSION


def release(record):
    """Forgets the binding that there is, and frees its memory, with that of others which nothing holds now."""
    session.cache.clear()
    declarations.clear(record)
