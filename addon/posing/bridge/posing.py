# SPDX-License-Identifier: GPL-3.0-or-later
"""What Bind and Solve hand to the solver: the gathered scene, and the calls to make with it. The binding is kept in the
.blend as a record, a fingerprint."""

from ... import ids, wording
from ...errors import ChangedMeanwhileError, SceneError, StaleBindingError
from ...scene import declarations, mesh_arrays, shape_keys, subject
from ...solver import session
from ...solver.core import fingerprint
from . import scene_input, targets

#: Of a Posing: the targets are where the controls are.
CONTROLS = ""


class Posing:
    """Arrays of one object; work() binds `bind_input` if there is no `binding`, and solves for `targets`, if any."""

    def __init__(self, obj, goal=None, is_checked=True, settles=False):
        """goal: CONTROLS, or the name of a shape key that has the targets; None to bind only. is_checked: it has to fit
        the binding on record. settles: the answer from rest, unless a rough one from the result that is there is lower.

        @throws SceneError; StaleBindingError if the artist has to look first.
        """
        self.bind_input = scene_input.gather(obj)
        if is_checked:
            require_fits(obj.meanvalue.bound, self.bind_input.fingerprint)
        self._goal = goal
        self.targets = self._gather_targets(obj, self.bind_input)
        self._start = shape_keys.result_positions(obj) if settles else None
        found = self.bind_input.fingerprint
        self.binding = session.cache.get(found)
        self._known = session.cache.relative(found.family) if self.binding is None else None
        is_new = self.binding is None and self._known is None
        shape = self.bind_input.rest, self.bind_input.face_corners
        self._triangles = mesh_arrays.triangles(obj.data, *shape) if is_new else None

    def _gather_targets(self, obj, bind_input):
        if self._goal is None:
            return None
        return targets.gather_from_key(obj, bind_input, self._goal) if self._goal else targets.gather(obj, bind_input)

    def work(self, execution):
        """Steps (see solver/job.py) to (n x 3 positions, native solution), None if bound. @throws MeanValueError."""
        if self.binding is None:
            self.binding = yield from session.bind_steps(self.bind_input, self._triangles, execution, known=self._known)
            self._triangles = self._known = None
        if self.targets is None:
            return None
        drag = session.begin_drag(self.binding, self.bind_input, self._start)
        return (yield from session.solve_steps(drag, self.targets, settle=True, execution=execution))

    def keep(self):
        """Keeps the binding for the session."""
        session.remember(self.bind_input, self.binding)

    def record(self, obj):
        """Keeps the binding for the session, and tells the file of it."""
        self.keep()
        write(obj.meanvalue.bound, self.bind_input.fingerprint)
        obj.update_tag()  # live posing may have waited for it

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if a script, a timer or another window made the scene another one."""
        problem = subject.object_problem(obj) or subject.mode_problem(obj)
        if problem is None:
            now = scene_input.gather(obj)
            goal = self._gather_targets(obj, now)
            is_same = now.fingerprint == self.bind_input.fingerprint
            if is_same and (goal is None or goal.is_near(self.targets, 0.0)):
                return
        raise ChangedMeanwhileError(obj.name)


def require_fits(record, now):
    """now: a Fingerprint. @throws StaleBindingError if the artist has to look first: else it is bound again."""
    changes = fingerprint.changes(record, now) if record.is_bound else ""
    if changes:
        raise StaleBindingError(f"{changes}. Check the handles and press Update")


def problem(obj):
    """(why a mesh object cannot be posed by what was read of it, as a sentence; whether Update mends that), or None."""
    model = scene_input.shown(obj)
    try:
        if model.is_known:
            require_fits(obj.meanvalue.bound, model.result(obj).fingerprint)
    except SceneError as error:
        return wording.sentence(str(error)), isinstance(error, StaleBindingError)
    return None


def write(record, now):
    """Remembers the binding of a Fingerprint: what of it the artist has to look at where it is another."""
    record.vertex_count, record.faces, record.rest_shape = now.vertex_count, now.faces, now.rest_shape
    record.is_bound, record.id_data.meanvalue.version = True, ids.SETTINGS_VERSION


def release(record):
    """Forgets the binding that there is, and frees its memory, with that of others which nothing holds now."""
    session.cache.clear()
    declarations.clear(record)
