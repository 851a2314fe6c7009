# SPDX-License-Identifier: GPL-3.0-or-later
"""Live where handles drive shape keys: the sliders go to where the keys are nearest to the handles.

The values are a function of where the controls are alone: so they change steadily in a drag, and are settled at once.
"""

import time

from ...posing.bridge import scene_input, targets
from ...posing.live.follower import Follower
from ...scene import key_reading, object_model, shape_keys
from ...solver import session
from ..core.key_drive import DriveInput
from . import driven_keys, key_shapes

REFUSED = "The shape keys cannot be driven by these handles: {}"

#: Of the mesh's size: handles that are missed by more are told of.
OUT_OF_REACH = 0.01


#: Of DriveInputs; sliders alone are written.
READING = object_model.Kind(
    lambda obj: (scene_input.signature(obj), len(obj.data.vertices), key_shapes.sorted_out(obj)),
    lambda obj: DriveInput(scene_input.read(obj, to_bind=False), key_shapes.gather(obj)),
    lambda found: key_reading.shapes(found.shapes),
    lambda _obj: "",
)


class KeyFollower(Follower):
    """What is bound is a native SliderFit."""

    READS = READING
    READS_AT_REST = True

    @staticmethod
    def asks_for(obj):
        return obj.meanvalue.live and driven_keys.is_on(obj)

    @staticmethod
    def why_hidden(obj):
        if obj.show_only_shape_key:
            return "A shape key is pinned. Turn off Shape Key Lock to see what the handles drive"
        if obj.meanvalue.baked.target:
            return shape_keys.BAKE_PLAYS
        result = shape_keys.result(obj)
        if result is None or result.mute or result.value == 0.0:
            return None
        return f"Shape key '{result.name}' shows a pose of its own on top of the keys that are driven. Mute it"

    def notes(self):
        if self._missed is not None:
            yield f"The shape keys do not reach as far as '{self._missed}'"
        note = key_shapes.left_alone_note(self._input.shapes.left_alone)
        if note:
            yield note

    def _begin_anew(self):
        super()._begin_anew()
        self._missed = None  # name of the handle that the keys do not reach

    def _is_shown(self, _obj):
        return self._wanted is not None and self._shown is self._wanted

    def _read_targets(self, obj):
        return self._targets.gather(obj, self._input.bind_input, self._wanted)

    def _do_chores(self, obj):
        self._targets.catch_up(obj, self._input.bind_input)

    @staticmethod
    def _cached_binding(found):
        """Made at once, since it takes no longer than to look it up. @throws SolverError."""
        return key_shapes.fit(found.shapes, found.shapes.fit_input(found.anchors), REFUSED, can_move=False)

    def _solve_work(self, _obj, **_options):
        fit, drive, wanted = self._binding, self._input, self._wanted
        names = drive.shapes.names

        def collect(obj, found):
            self._shown, self._is_settled = wanted, wanted is self._wanted
            number, distance = drive.farthest(found.residuals)
            handle = targets.enabled_handles(obj)[number]
            self._missed = handle.name if distance > OUT_OF_REACH * drive.diagonal else None
            key_shapes.set_values(obj, names, found.values)

        def work(_execution):
            begun = time.perf_counter()
            found = yield from session.steps(
                fit.start_solve,
                drive.targets(wanted.positions),
                drive.weights(wanted.weights),
                steady=True,
                refused=REFUSED,
            )
            self.solve_seconds = time.perf_counter() - begun
            return lambda obj: collect(obj, found)

        return work
