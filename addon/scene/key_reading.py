# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shape keys and what masks them."""

from . import shape_keys, vertex_groups
from .core.key_shapes import Slider
from .core.point_sets import require_finite


def slider_of(obj, key):
    """The Slider of a shape key of `obj`. A vertex group that is gone masks nothing, as in Blender."""
    group = key.vertex_group if key.vertex_group in obj.vertex_groups else ""
    return Slider(key.name, key.slider_min, key.slider_max, key.relative_key.name, group)


def parts(obj, sliders):
    """The arguments of the KeyShapes of `sliders`. @throws SceneError."""
    rest = shape_keys.rest_positions(obj.data)
    require_finite(rest, "rest shape")
    points = {name: shape_keys.checked(obj, name) for each in sliders for name in (each.name, each.relative)}
    masks = vertex_groups.weights(obj, {each.group for each in sliders})
    return {"sliders": tuple(sliders), "rest": rest, "points": points, "masks": masks}


def shapes(found):
    """As of a Kind of reading, for what has the rest shape and points of a KeyShapes."""
    return [("", found.rest), *found.points.items()]
