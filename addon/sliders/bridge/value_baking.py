# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of Bake Shape Key Values: anchors over time, the values that fit them, and their F-curves."""

import numpy as np

from ... import wording
from ...baking.core import bake_times
from ...errors import ChangedMeanwhileError, SceneError
from ...scene import pose_key, shape_keys
from ...scene.core import point_sets
from ...solver import session
from . import head_motion, key_shapes
from .anchor_sources import HandleAnchors, MarkerAnchors

SOURCES = {'HANDLES': HandleAnchors, 'MARKERS': MarkerAnchors}

#: Targets that were not followed are told of from this distance on, as a share of the size of the mesh.
TOLD = 0.002

#: What is no more is 0, so that keys at rest are.
ROUNDING = 1e-6

REFUSED = "No values can be found: {}"


def problem(obj):
    """Why there is nothing that values could follow, or None. Either source may be given to the operator."""
    found = {name: source.problem(obj) for name, source in SOURCES.items()}
    return found[obj.meanvalue.bake_values.source] if all(found.values()) else None


class ValueBaking:
    """One object with its options (attributes as properties.py), in place of a Posing for widgets/background.py."""

    def __init__(self, obj, scene, options):
        """@throws SceneError; nothing was changed then."""
        self.options = options
        self.shapes = key_shapes.gather(obj)
        self._size = point_sets.bounding_box_diagonal(self.shapes.rest)
        self.source = SOURCES[options.source](obj, scene, options, self.shapes)
        self._require_room(obj)
        self.solved = self.fit = None
        self.curves = {}

    def _require_room(self, obj):
        key_shapes.require_room(obj, self.shapes.names, self.options.replace)
        head_motion.require_room(obj, self.options)

    def work(self, execution):
        """Steps (see solver/job.py) to the native SliderValues of all frames. @throws SolverError, CancelledError."""
        source = self.source
        rest, shapes, places = self.shapes.fit_input(source.anchors)
        rest[places] += source.offsets
        shapes[:, places] += source.offsets
        self.fit = key_shapes.fit(
            self.shapes, (rest, shapes, places), REFUSED, can_move=self.options.head_motion != head_motion.STILL
        )
        self.solved = yield from session.steps(
            self.fit.start_solve_sequence, source.targets, source.weights, execution=execution, refused=REFUSED
        )

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if the shape keys are others by now."""
        if key_shapes.gather(obj).revision != self.shapes.revision:
            raise ChangedMeanwhileError(obj.name)
        self._require_room(obj)

    def reduce(self):
        """Generator of the share done: chooses the keys of the values that anchors see."""
        seen = [number for number in range(len(self.shapes.names)) if number not in self.fit.unseen]
        values = np.where(np.abs(self.solved.values) < ROUNDING, 0.0, self.solved.values)
        frames = self.source.frames
        for done, number in enumerate(seen):
            of_key = values[:, number]
            kept = list(range(len(frames)))
            if self.options.tolerance > 0.0:
                rows = of_key.reshape(-1, 1, 1)
                kept = yield from bake_times.reduced(rows, frames, self.options.tolerance)
            self.curves[self.shapes.names[number]] = frames[kept], of_key[kept]
            yield (done + 1) / len(seen)

    def write(self, obj):
        """F-curves; nothing poses the mesh besides. Returns notes. @throws SceneError, with nothing changed."""
        if not self.curves:
            raise SceneError(f"The {self.source.words} move with no shape key of '{obj.name}'. Put some where keys act")
        self._require_room(obj)
        notes = key_shapes.write(obj, self.curves, self.options.replace)
        if self.options.head_motion in (head_motion.ON_OBJECT, head_motion.ON_BONE):
            source = self.source
            notes += head_motion.write(obj, self.options, source.frames, source.pairs, self.solved.transform)
        obj.meanvalue.live = False
        result = shape_keys.result(obj)
        if result is not None and result.name not in self.curves and not result.mute and result.value:
            pose_key.show(result, None)
            notes.append(f"Shape key '{result.name}' is muted, so that it is not added to the values")
        if obj.meanvalue.baked.target:
            notes.append(shape_keys.BAKE_PLAYS)
        return [*self.source.notes, *self._notes(), *notes]

    def account(self, obj):
        """What was done, in words: a sentence, then details."""
        off = np.linalg.norm(self.solved.residuals, axis=2)
        off = off[~self.solved.outliers & ~np.isnan(off)]
        frames = wording.counted(len(self.source.frames), "frame")
        told = [f"Baked {frames} of {wording.counted(len(self.curves), 'shape key')} of '{obj.name}'"]
        if len(off):
            told.append(f"It is {wording.share(off.mean() / self._size)} of its size from the {self.source.words}")
        return told

    def _notes(self):
        words, names = self.source.words, self.shapes.names
        with np.errstate(invalid="ignore"):  # where a target is missing
            off = np.linalg.norm(self.solved.residuals, axis=2) > TOLD * self._size
        outliers = self.solved.outliers & off
        if outliers.any():
            worst = np.argsort(-outliers.sum(axis=0), kind="stable")
            who = dict.fromkeys(self.source.names[number] for number in worst if outliers[:, number].any())
            frames = wording.counted(int(outliers.any(axis=1).sum()), "frame")
            yield f"Some {words} were too far off to be followed in {frames}: {wording.quoted(who)}"
        if self.fit.unseen:
            yield f"The {words} do not see {wording.quoted(names[number] for number in self.fit.unseen)}: left alone"
        for one, other in self.fit.alike:
            yield f"To the {words} '{names[one]}' and '{names[other]}' look alike, so they may be taken for each other"
        left_alone = key_shapes.left_alone_note(self.shapes.left_alone)
        if left_alone:
            yield left_alone
