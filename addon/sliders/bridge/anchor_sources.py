# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the anchors of a face are over time: by animated handles, or by the markers of a take.

Both have, once sample() went through:

names    k names, of the handle or the marker of each anchor
anchors  (k,) vertex indices, each once
offsets  (k, 3) float64 from the vertices at rest to what is followed, which go with the head; object space
frames   (f,) float64 of the scene
targets  (f, k, 3) float64 in the object's space, NaN where one is missing
weights  (f, k) float64, 0 to 1, or None
pairs    (f, 2, 4, 4) float64: the two matrices of head_motion.pair() in each frame
notes    sentences
"""

from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np

from ... import wording
from ...baking.bridge import handle_source, preparing
from ...capture.bridge import marker_matching, match_input
from ...errors import SceneError
from ...posing.bridge import scene_input, targets
from ...scene import frames
from ...scene.core import motion
from ..core.key_drive import DriveInput
from . import head_motion

#: Fewer leave open how the head is turned.
LEAST_MARKERS = 3

#: A marker is stuck that moves less than this share of what they usually do; one that is farther from the surface than
#: this share of how far they usually are from their middle is of something else.
STILL, FAR = 1e-3, 0.5

#: What a face needs of the options of Match Markers, which are for bodies.
OF_FACES = {"pose_limbs": False, "use_cuffs": False, "mode": 'AS_CAPTURED', "is_of_body": False}


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
