# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape keys of a mesh are examples of how it bends (Pose Like), and what they hold."""

from ... import ids
from ...errors import SceneError, require_none
from ...scene import key_marks, key_reading, shape_keys
from ...scene.core.key_shapes import KeyShapes, Slider
from ...scene.key_marks import Role


def keys(obj):
    """A Slider for each shape key that is an example; none if Pose Like is Nothing.

    Own Shape Keys leaves out muted keys, what the add-on itself writes, and kept poses that nobody has renamed. Quick
    enough for drawing.
    """
    found, like = obj.data.shape_keys, obj.meanvalue.pose_like
    if like == ids.LIKE_NOTHING or found is None:
        return ()
    poses, made = shape_keys.rig_poses(obj), shape_keys.made_names(obj)

    def is_example(key):
        if like == ids.LIKE_RIG:
            return key.name in poses
        is_kept = key.slider_min == key_marks.mark(Role.KEPT, key.name)
        return made.isdisjoint((key.name, key.relative_key.name)) and not (is_kept or key.mute)

    return sliders(key for key in found.key_blocks if key != found.reference_key and is_example(key))


def sliders(keys):
    """A Slider for each of some shape keys, up to the value 1."""
    return tuple(Slider(key.name, 0.0, 1.0, key.relative_key.name, key.vertex_group) for key in keys)


def gather(obj):
    """The KeyShapes of `obj`, or None where it is posed like nothing. @throws SceneError."""
    like = obj.meanvalue.pose_like
    if like == ids.LIKE_NOTHING:
        return None
    if obj.meanvalue.method != ids.METHOD_FAST:
        raise SceneError("Pose Like needs the method Fast. Choose it in Advanced, or choose Nothing in Pose Like")
    require_none(shape_keys.absolute_problem(obj))
    found = KeyShapes(**key_reading.parts(obj, keys(obj))).with_effect()
    if not found.names:
        remedy = "Press Sample Rig Poses" if like == ids.LIKE_RIG else "Add one in which it is bent, and unmute it"
        raise SceneError(f"There is no shape key that shows how it bends. {remedy}, or choose Nothing in Pose Like")
    return found
