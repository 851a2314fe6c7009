# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the handles of an object drive its shape keys, which then show the pose in place of the result;
what they do not reach, as one more shape key."""

import dataclasses

import numpy as np

from ... import ids
from ...errors import ChangedMeanwhileError, SceneError, require_none
from ...posing.bridge import scene_input, targets
from ...scene import actions, key_marks, mesh_arrays, pose_key, shape_keys
from ...scene.core import welding
from ...scene.key_marks import Role
from ...solver import session
from ...solver.core import result
from . import key_shapes

SHAPE, KEYS = 'SHAPE', 'SHAPE_KEYS'


def is_on(obj):
    return obj.meanvalue.drive == KEYS


def problem(obj):
    return None if is_on(obj) else "Handles drive no shape keys. Choose Shape Keys in Drive"


def names(obj):
    """Of the shape keys that show the pose, the corrective among them; none where the result does."""
    if not is_on(obj):
        return []
    driven = [slider.name for slider in key_shapes.sorted_out(obj)[0]]
    corrective = key_marks.only(obj.data.shape_keys, Role.CORRECTIVE)
    return driven if corrective is None else [*driven, corrective.name]


def positions(obj):
    """n x 3 float32: the mesh as its keys show it; None where the result does, or there are no keys to drive."""
    if not is_on(obj):
        return None
    try:
        shapes = key_shapes.gather(obj)
    except SceneError:  # told where they are to be driven
        return None
    return shapes.mixed(key_shapes.values(obj, shapes.names)).astype(np.float32)


def keyframe(obj):
    """Keys the values at the current frame. Returns what was keyed, in words; None where handles drive no keys.

    @throws SceneError.
    """
    if not is_on(obj):
        return None
    require_none(key_shapes.problem(obj))
    driven = names(obj)
    for name in driven:
        actions.insert_key(obj.data.shape_keys.key_blocks[name], "value")
    return len(driven), "shape key"


def chosen(obj):
    """Drive was chosen. The result, which posing by its shape writes, is not to be added to what keys show."""
    result = shape_keys.result(obj)
    if result is not None and result != obj.data.shape_keys.reference_key:
        pose_key.show(result, None if is_on(obj) else 1.0)
    obj.update_tag()


#: Of the mesh's size: what moves no vertex by more is no corrective.
NOTHING = 1e-5


class Corrective:
    """Poses the mix of the sliders by the handles, in place of a Posing for widgets/background.py.

    Pose Like has no say: the mix is what the mesh is to look like.
    """

    def __init__(self, obj):
        """@throws SceneError."""
        self._held = scene_input.gather(obj, to_bind=False)
        self._targets = targets.gather(obj, self._held)
        shapes = key_shapes.gather(obj)
        self._mix = shapes.mixed(key_shapes.values(obj, shapes.names)).astype(np.float32)
        copies = welding.together(self._held.copies, [self._mix], obj.meanvalue.merge_distance)
        self._bind_input = dataclasses.replace(self._held, rest=self._mix, copies=copies)
        self._bind_input.check()
        self._triangles = mesh_arrays.triangles(obj.data, self._mix)

    def work(self, execution):
        """Steps (see solver/job.py) to the n x 3 float32 shape in which handles are met. @throws MeanValueError."""
        binding = yield from session.bind_steps(self._bind_input, self._triangles, execution)
        drag = session.begin_drag(binding, self._bind_input)
        solved, _summary = yield from session.solve_steps(drag, self._targets, settle=True, execution=execution)
        return result.compose(self._bind_input, self._targets.positions, solved)

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if handles, keys or their values are others by now."""
        now = Corrective(obj)
        is_same = now._held.fingerprint == self._held.fingerprint and np.array_equal(now._mix, self._mix)
        if not is_same or not now._targets.is_near(self._targets, 0.0):
            raise ChangedMeanwhileError(obj.name)

    def write(self, obj, shape):
        """The name of the key, shown fully, which is relative to the rest shape. @throws SceneError."""
        offset = shape - self._mix
        if np.abs(offset).max(initial=0.0) <= NOTHING * self._held.diagonal:
            raise SceneError("The shape keys reach all handles, so there is nothing left for a corrective")
        keys = obj.data.shape_keys
        points = self._held.rest + offset
        key = key_marks.only(keys, Role.CORRECTIVE) or shape_keys.add_shape(obj, ids.CORRECTIVE_KEY, points)
        key.slider_min = key_marks.mark(Role.CORRECTIVE)
        key_marks.claim(key)
        shape_keys.write_positions(obj.data, key, points)
        shape_keys.show_fully(keys, key)
        return key.name
