# SPDX-License-Identifier: GPL-3.0-or-later
"""Which shape keys of a mesh are examples of how it bends (Pose Like), and what they hold."""

from ... import ids
from ...errors import SceneError
from ...scene import key_marks, shape_keys
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

    return tuple(
        Slider(key.name, 0.0, 1.0, key.relative_key.name, key.vertex_group)
        for key in found.key_blocks
        if key != found.reference_key and is_example(key)
    )


def groups(obj):
    """Names of the vertex groups that say how much the keys count where."""
    return {key.group for key in keys(obj) if key.group}


def gather(obj, rest, weights):
    """The KeyShapes of `obj`, or None where it is posed like nothing. @throws SceneError.

    rest: n x 3 float32; weights: {vertex group: n float64} of at least groups()
    """
    like = obj.meanvalue.pose_like
    if like == ids.LIKE_NOTHING:
        return None
    if obj.meanvalue.method != ids.METHOD_FAST:
        raise SceneError("Pose Like needs the method Fast. Choose it in Advanced, or choose Nothing in Pose Like")
    if shape_keys.absolute_problem(obj):
        raise SceneError(shape_keys.ABSOLUTE)
    used = keys(obj)
    names = dict.fromkeys(name for key in used for name in (key.name, key.relative))
    points = {name: shape_keys.checked(obj, name) for name in names}
    masks = {key.group: weights[key.group] for key in used if key.group in weights}
    found = KeyShapes(sliders=used, rest=rest, points=points, masks=masks).with_effect()
    if not found.names:
        remedy = "Press Sample Rig Poses" if like == ids.LIKE_RIG else "Add one in which it is bent, and unmute it"
        raise SceneError(f"There is no shape key that shows how it bends. {remedy}, or choose Nothing in Pose Like")
    return found
