# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys that a rotation-aware mix is made of. Their sliders, groups and switches are Blender's own.
And those that stand for a mix, each driven by the sliders that it is a correction of; and the shape of another object,
for a key of this one."""

import bpy
import numpy as np

from ... import ids, wording
from ...errors import SceneError, require_none
from ...scene import actions, kept, key_marks, mirrors, object_model, shape_keys, subject, vertex_groups
from ...scene.baked import names_in
from ...scene.core import motion
from ...scene.core.point_sets import require_finite
from ...scene.key_marks import Role
from ..core import in_betweens
from ..core.in_betweens import MixInput


def mix_names(obj):
    """The name of the key that turns the mix, in a list; empty if there is none."""
    key = key_marks.only(obj.data.shape_keys, Role.MIX)
    return [] if key is None else [key.name]


def mixed(obj):
    """The shape keys that are mixed, in their order: all shown ones but the rest shape and what the add-on makes."""
    keys = obj.data.shape_keys
    if keys is None:
        return []
    baked = obj.meanvalue.baked
    made = {*mix_names(obj), *in_between_names(obj), *names_in(baked.keys)}
    muted_by_bake = names_in(baked.muted) if baked.was_mixed else ()
    return [
        key
        for key in keys.key_blocks
        if key != keys.reference_key and key.name not in made and (not key.mute or key.name in muted_by_bake)
    ]


def in_between_names(obj):
    """Names of the in-between keys that stand for a mix, by their drivers. All objects with the mesh share them."""
    keys = obj.data.shape_keys
    if keys is None or keys.animation_data is None:
        return []
    paths = {curve.data_path for curve in keys.animation_data.drivers if ids.MIX_MARK in curve.driver.variables}
    return [key.name for key in keys.key_blocks if key.path_from_id("value") in paths] if paths else []


def problem(obj):
    """Why the keys cannot be mixed, or None. Cheap enough for drawing."""
    keys = obj.data.shape_keys
    if keys is None:
        return "There are no shape keys to mix. Add some, or take the shape of another object by Morph to Selected"
    if not keys.use_relative:
        return shape_keys.ABSOLUTE
    taking_part = mixed(obj)
    if not taking_part:
        return "There is no shape key but the rest shape, or all others are muted. Add one, or turn one on"
    others = [key.name for key in taking_part if key.relative_key != keys.reference_key]
    if others:
        basis = keys.reference_key.name
        return f"{wording.quoted(others)}: relative to another key than '{basis}'. Set Relative To, or mute them"
    lost = [key.name for key in taking_part if key.vertex_group and key.vertex_group not in obj.vertex_groups]
    if lost:
        return f"The vertex group of shape key {wording.quoted(lost)} is gone. Choose another, or clear the field"
    return None


def make_key(obj):
    """Makes the key that turns the mix, shown fully. It is in the rest shape: it adds nothing yet."""
    last = shape_keys.unmarked(obj, Role.MIX, ids.MIX_KEY, key_marks.mark(Role.MIX))
    shape_keys.write_only(obj, Role.MIX, last, ids.MIX_KEY, shape_keys.rest_positions(obj.data))


def carry_over():
    """Objects may come from an older file: before shape keys had marks, the key had its name alone."""
    for obj in bpy.data.objects:
        if obj.meanvalue.mix.is_on and obj.type == 'MESH' and obj.data.library is None and not mix_names(obj):
            key = obj.data.shape_keys and obj.data.shape_keys.key_blocks.get(ids.MIX_KEY)
            if key and key.value == 1.0 and shape_keys.WRITTEN[Role.MIX] not in obj.data.shape_keys:
                key.slider_min = key_marks.mark(Role.MIX)


def why_hidden(obj):
    """Why the mix does not show as it is, or None."""
    key = key_marks.only(obj.data.shape_keys, Role.MIX)
    if key is not None and (key.mute or key.value != 1.0 or key.vertex_group):
        return f"Shape key '{key.name}', which turns the mix, is not shown fully. Delete it: it is made again"
    if obj.show_only_shape_key:
        return "A shape key is pinned. Turn off Shape Key Lock to see the mix"
    if obj.meanvalue.baked.target:
        return shape_keys.BAKE_PLAYS
    return None


def gather(obj):
    """The MixInput of `obj`. @throws SceneError."""
    require_none(problem(obj))
    found = vertex_groups.shapes_of(obj, _sliders(obj))
    whole, triangles = mirrors.whole(obj, found.points.values())
    return MixInput(found.sliders, found.rest, found.points, found.masks, triangles=triangles, whole=whole)


def _sliders(obj):
    return [vertex_groups.slider_of(obj, key) for key in mixed(obj)]


READING = object_model.Kind(
    lambda obj: (len(obj.data.vertices), _sliders(obj), kept.seam_settings(obj), mirrors.signature(obj)),
    gather,
    vertex_groups.key_shapes,
    lambda obj: key_marks.only(obj.data.shape_keys, Role.MIX),
)


#: A polynomial may go below 0 and above 1 between the places of its sliders.
FARTHEST = 10.0


def make_in_betweens(obj, mix_input, found):
    """Keys with their drivers for a Found, in place of what stood for a mix before."""
    remove_in_betweens(obj)
    shape_keys.remove(obj, mix_names(obj))
    names = mix_input.names
    knots = [in_betweens.places(slider.low, slider.high) for slider in mix_input.sliders]
    for each in found.shapes:
        shape = (mix_input.rest + each.offset).astype(np.float32)
        key = shape_keys.add_shape(obj, in_betweens.label(names, knots, each.orders), shape)
        key.slider_min, key.slider_max = -FARTHEST, FARTHEST
        text, sliders = in_betweens.expression(knots, each.orders)
        others = [obj.data.shape_keys.key_blocks[names[slider]] for slider in sliders]
        variables = dict(zip(in_betweens.VARIABLES, others, strict=False))
        actions.drive(key, {**variables, ids.MIX_MARK: others[0]}, text)  # the last is not in the expression


def remove_in_betweens(obj):
    """Takes away what make_in_betweens() has made. Returns how many keys there were."""
    names = in_between_names(obj)
    shape_keys.remove(obj, names)
    return len(names)


def shape_of(source, obj):
    """(n x 3: the shape of `source`, its keys as they are set and without modifiers, in the space of `obj`; whether its
    origin was laid on that of `obj`, as of one that stands beside: where that is nearer). @throws SceneError."""
    keys = source.data.shape_keys
    if source.data.is_editmode:
        raise SceneError(f"'{source.name}' is in Edit Mode. Leave that first")
    keys = keys.key_blocks[1:] if keys is not None and keys.use_relative else ()
    keys = [key for key in keys if key.value and not key.mute]
    shapes = vertex_groups.shapes_of(source, [vertex_groups.slider_of(source, key) for key in keys])
    shape = shapes.mixed([key.value for key in keys])
    require_finite(shape, f"shape of '{source.name}'")
    shape = shape.astype(np.float32)
    own, other = subject.to_world(obj), subject.to_world(source)
    if motion.same(own, other):
        return shape, False
    matrix = np.linalg.inv(own) @ other
    rest = shape_keys.rest_positions(obj.data)
    stands, laid = motion.apply(matrix, shape), motion.apply(motion.affine(matrix[:3, :3]), shape)
    is_laid = bool(np.linalg.norm(laid - rest) < np.linalg.norm(stands - rest))
    return laid if is_laid else stands, is_laid
