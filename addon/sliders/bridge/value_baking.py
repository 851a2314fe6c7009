# SPDX-License-Identifier: GPL-3.0-or-later
"""The work of Bake Shape Key Values: anchors over time, the values that fit them, and their F-curves."""

from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np

from ... import wording
from ...baking.bridge import handle_source, preparing
from ...baking.core import bake_times
from ...capture.bridge import marker_matching, match_input
from ...errors import ChangedMeanwhileError, SceneError
from ...posing.bridge import scene_input, targets
from ...scene import frames, key_marks, shape_keys
from ...scene.core import motion, point_sets
from ...solver import session
from . import head_motion, key_shapes
from .driven_keys import DriveInput

#: Fewer leave open how the head is turned.
LEAST_MARKERS = 3

#: A marker is stuck that moves less than this share of what they usually do; one that is farther from the surface than
#: this share of how far they usually are from their middle is of something else.
STILL, FAR = 1e-3, 0.5

#: What a face needs of the options of Match Markers, which are for bodies.
OF_FACES = {"pose_limbs": False, "mode": 'AS_CAPTURED', "is_of_body": False}


class HandleAnchors:
    """What the enabled handles hold."""

    words = "handles"
    notes = ()
    problem = staticmethod(scene_input.unheld_problem)

    def __init__(self, obj, scene, options, shapes):
        """@throws SceneError."""
        self._drive = DriveInput(scene_input.gather(obj, to_bind=False), shapes)
        handle_source.require_evaluated(obj)
        self._scene_name, self._options = scene.name, options
        handles = targets.enabled_handles(obj)
        self.names = [handles[number].name for number in self._drive.handles]
        self.anchors = self._drive.anchors
        self.offsets = np.zeros((len(self.anchors), 3))
        self.frames = preparing.times_of(scene, obj, SimpleNamespace(**vars(options), samples=1))

    def sample(self, find):
        """Generator of the share that is done. find() returns the object. @throws SceneError."""

        def read():
            obj = find()
            return handle_source.row(obj, self._drive.bind_input), head_motion.pair(obj, self._options)

        read_rows = yield from frames.visit(bpy.data.scenes[self._scene_name], self.frames, read)
        rows, pairs = (np.array(part) for part in zip(*read_rows, strict=True))
        rows = rows[:, : 4 * len(self._drive.bind_input.anchors)].reshape(len(rows), -1, 4)
        self.weights = self._drive.weights(rows[..., 3])
        self.targets, self.pairs = self._drive.targets(rows[..., :3]), pairs


class MarkerAnchors:
    """The markers of the take that the object follows, each on the surface nearest to it in the reference frame."""

    words = "markers"
    weights = None
    problem = staticmethod(match_input.problem)

    def __init__(self, obj, scene, options, _shapes):
        self._scene_name, self._options = scene.name, options
        self._reference = match_input.reference_frame(obj)

    def sample(self, find):
        """As of HandleAnchors. The object counts as it is in the reference frame, so that it may be baked again."""

        def read():
            return match_input.read(find()), head_motion.pair(find(), self._options)

        scene = bpy.data.scenes[self._scene_name]
        ((given, pair),) = yield from frames.visit(scene, [self._reference], read)
        align = 'NONE' if given.options.align == 'NONE' else 'PICKED'  # Automatic is for bodies
        of_face = SimpleNamespace(**{**vars(given.options), **OF_FACES, "align": align})
        matched = marker_matching.find(replace(given, options=of_face))
        recording = given.recording
        columns = [recording.labels.index(name) for name in matched.names]
        path = motion.apply(matched.alignment, recording.positions[:, columns])
        used, self.notes = _of_face(matched, path, given.picked)
        first, last = {
            'ANIMATION': (-np.inf, np.inf),
            'SCENE': (scene.frame_start, scene.frame_end),
            'OWN': (self._options.frame_start, self._options.frame_end),
        }[self._options.frame_range]
        within = (recording.frames >= first) & (recording.frames <= last)
        if not within.any():
            raise SceneError(f"The take has no sample from frame {first} to {last}. Choose another Range")
        self.names = [matched.names[number] for number in used]
        self.anchors, self.offsets = matched.vertices[used], matched.offsets[used]
        self.frames, self.targets = recording.frames[within], path[within][:, used]
        self.pairs = np.broadcast_to(pair, (len(self.frames), 2, 4, 4))


def _of_face(matched, path, picked):
    """(numbers of the markers that tell something of the face, notes on the others). @throws SceneError."""
    moves = (np.fmax.reduce(path) - np.fmin.reduce(path)).max(axis=1)
    spread = np.median(np.linalg.norm(matched.rest - np.median(matched.rest, axis=0), axis=1))
    is_still = moves < STILL * np.nanmedian(moves)
    is_far = matched.distance * matched.size / matched.world_size > FAR * spread
    is_far &= [name not in picked for name in matched.names]
    notes, used = [], np.flatnonzero(~is_still & ~is_far)
    for flags, words in ((is_still, "never move"), (is_far & ~is_still, "lie far from the surface")):
        if flags.any():
            names = wording.quoted(np.array(matched.names)[flags], limit=8)
            notes.append(f"Left out, since they {words}: {names}")
    if len(used) < LEAST_MARKERS:
        count = wording.counted(len(used), "marker")
        remedy = ". ".join([*notes, "Check the picked points and the Reference Frame"])
        raise SceneError(f"{count} can be used, and the face needs {LEAST_MARKERS}. {remedy}")
    return used, notes


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
            key_marks.show(result, None)
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
