# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape keys of a mesh are examples of how it bends (Pose Like), and what they hold; poses of
its own rig among them: muted shape keys, for the artist to see, edit and delete."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import ChangedMeanwhileError, SceneError, require_none
from ...scene import frames, key_marks, rig_space, shape_keys, vertex_groups
from ...scene.core import motion, point_sets
from ...scene.core.point_sets import require_finite
from ...scene.key_marks import Role


def keys(obj):
    """A Slider for each shape key that is an example; none if Pose Like is Nothing. Quick enough for drawing."""
    found, like = obj.data.shape_keys, obj.meanvalue.pose_like
    if like == ids.LIKE_NOTHING or found is None:
        return ()
    poses, made = shape_keys.rig_poses(obj), shape_keys.made_names(obj)

    def is_example(key):
        if like == ids.LIKE_RIG:
            return key.name in poses
        is_kept = key.slider_min == key_marks.mark(Role.KEPT, key.name)
        return made.isdisjoint((key.name, key.relative_key.name)) and not (is_kept or key.mute)

    keys = (key for key in found.key_blocks if key != found.reference_key and is_example(key))
    return tuple(vertex_groups.slider_of(obj, key) for key in keys)


def shown_by(obj):
    """The KeyShapes of `obj`, or None where it is posed like nothing. @throws SceneError."""
    like = obj.meanvalue.pose_like
    if like == ids.LIKE_NOTHING:
        return None
    if obj.meanvalue.method != ids.METHOD_FAST:
        raise SceneError("Pose Like needs the method Fast. Choose it in Advanced, or choose Nothing in Pose Like")
    require_none(shape_keys.absolute_problem(obj))
    found = vertex_groups.shapes_of(obj, keys(obj)).with_effect()
    if not found.names:
        remedy = "Press Sample Rig Poses" if like == ids.LIKE_RIG else "Add one in which it is bent, and unmute it"
        raise SceneError(f"There is no shape key that shows how it bends. {remedy}, or choose Nothing in Pose Like")
    return found


#: Frames that are looked at, and vertices by which poses are compared: spread evenly where there are more.
MOST_FRAMES, MOST_VERTICES = 250, 2000

#: Of the mesh's size: poses nearer to each other are one.
SAME_POSE = 2e-3


def rig_problem(obj):
    """Why no poses can be sampled, in words, or None. Cheap enough for drawing."""
    if not rig_space.deformers(obj):
        return f"'{obj.name}' follows no rig. Give it an Armature or another modifier that deforms it"
    return shape_keys.absolute_problem(obj)


class RigPoses:
    """Samples one object, in place of a Posing for widgets/background.py."""

    def __init__(self, obj, scene, most):
        """most: how many poses are wanted. @throws SceneError."""
        self._most, self._scene_name = most, scene.name
        self._rest = shape_keys.rest_positions(obj.data).astype(np.float64)
        rigs = (getattr(modifier, "object", None) for modifier in obj.modifiers)
        first, last = frames.moved_range(scene, frames.movers([obj, *rigs]))
        count = min(last - first + 1, MOST_FRAMES)
        self._times = np.unique(np.linspace(first, last, count).round())
        self._found = []  # frames, and n x 3 float32 of each

    def sample(self, find):
        """Generator of the share that is done. find() returns the object. @throws SceneError."""
        scene = bpy.data.scenes[self._scene_name]
        rows = slice(None, None, -(-len(self._rest) // MOST_VERTICES))
        poses = yield from frames.visit(scene, self._times, lambda: self._seen(find())[rows].copy())
        least = SAME_POSE * point_sets.bounding_box_diagonal(self._rest)
        chosen = self._times[motion.differing(self._rest[rows], np.array(poses), self._most, least)]
        if not len(chosen):
            first, last = (wording.frame(self._times[row]) for row in (0, -1))
            raise SceneError(f"'{find().name}' keeps its shape from frame {first} to {last}. Animate its rig there")
        shapes = yield from frames.visit(scene, chosen, lambda: self._seen(find()).astype(np.float32))
        self._found = list(zip(chosen, shapes, strict=True))

    def _seen(self, obj):
        """n x 3 float64: what the rig makes of the rest shape. @throws SceneError."""
        with rig_space.evaluating(obj) as evaluate:
            shape = evaluate(self._rest)
        require_finite(shape, f"mesh behind {rig_space.named(obj)}")
        return shape

    def work(self, _execution):
        """Nothing is solved."""
        yield from ()

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if the mesh is another one by now."""
        if not np.array_equal(shape_keys.rest_positions(obj.data), self._rest.astype(np.float32)):
            raise ChangedMeanwhileError(obj.name)

    def write(self, obj):
        """Muted shape keys in place of those of before. Returns their names."""
        shape_keys.remove(obj, shape_keys.rig_poses(obj))
        names = []
        for frame, shape in self._found:
            key = shape_keys.add_shape(obj, f"{ids.RIG_POSE_KEY} {wording.frame(frame)}", shape)
            key.mute = True
            key.slider_min = key_marks.mark(Role.RIG_POSE, key.name)
            names.append(key.name)
        obj.meanvalue.pose_like = ids.LIKE_RIG
        return names
