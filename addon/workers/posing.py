# SPDX-License-Identifier: GPL-3.0-or-later
"""What Bind, Solve and live posing hand to a thread: the gathered scene, and the calls to make with it."""

from .. import session
from ..bridge import bound_record, mesh_arrays, scene_input, targets
from ..core import fingerprint
from ..errors import SceneError, StaleBindingError


class Posing:
    """Arrays of one object, gathered on the main thread; work() binds if need be and solves, on any thread.

    bind_input  what is bound; binding  the Binding, None until there is one
    targets     where the anchors go; None to bind only
    changes     what changed since the binding on record, in words, "" if nothing
    """

    def __init__(self, obj, bind_input, goal=None, changes=""):
        self.bind_input = bind_input
        self.targets = goal
        self.changes = changes
        self.binding = session.cached(bind_input)
        self._triangles = None if self.binding else mesh_arrays.triangles(obj.data, bind_input)

    @classmethod
    def to_bind(cls, obj):
        """@throws SceneError."""
        return cls(obj, scene_input.gather(obj))

    @classmethod
    def to_solve(cls, obj):
        """@throws SceneError; StaleBindingError if the artist has to look first."""
        bind_input = scene_input.gather(obj)
        changes = _what_changed(obj, bind_input)
        return cls(obj, bind_input, targets.gather(obj, bind_input), changes)

    def work(self, execution):
        """(n x 3 positions, SolveSummary) if there are targets, else None. @throws MeanValueError."""
        if self.binding is None:
            self.binding = session.bind(self.bind_input, self._triangles, execution)
            self._triangles = None
        if self.targets is None:
            return None
        return session.solve(self.binding, self.bind_input, self.targets.positions, execution=execution)

    def keep(self):
        """Keeps the binding for the session."""
        session.remember(self.bind_input, self.binding)

    def record(self, obj):
        """Keeps the binding for the session, and tells the file of it."""
        self.keep()
        bound_record.write(obj.meanvalue.bound, self.bind_input.fingerprint, self.binding.summary)
        obj.update_tag()  # live posing may have waited for it

    def require_unchanged(self, obj):
        """@throws SceneError if the mesh is another one by now, as after a script ran meanwhile."""
        if obj.mode != 'OBJECT' or len(obj.data.vertices) != len(self.bind_input.rest):
            raise SceneError(f"'{obj.name}' was changed while it was worked on, so the result is dropped. Try again")


def _what_changed(obj, bind_input):
    """What changed since the binding on record that need not stop us, in words; "" if nothing.

    @throws StaleBindingError if the artist has to look first.
    """
    bound = bound_record.read_fingerprint(obj.meanvalue.bound)
    reasons = fingerprint.stale_reasons(bound, bind_input.fingerprint)
    changes = fingerprint.describe(reasons, bound, bind_input.fingerprint)
    if fingerprint.needs_bind(reasons):
        raise StaleBindingError(f"The binding is stale: {changes}. Check the anchors and press Bind")
    return changes
