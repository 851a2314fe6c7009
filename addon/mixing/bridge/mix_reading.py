# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the shape keys that are mixed."""

from ... import wording
from ...errors import SceneError
from ...scene import key_marks, mesh_arrays, mirrors, seams
from ...scene.core import welding
from ...scene.core.key_shapes import Slider
from ...scene.key_marks import Role
from ...scene.key_reading import KeyReading
from ..core.mix_input import MixInput
from . import mixed_keys


class MixReading(KeyReading):
    """A kind of reading as scene/object_model.py wants it, of MixInputs."""

    def __init__(self, obj):
        found = mixed_keys.problem(obj)
        if found:
            raise SceneError(found)
        sliders = [
            Slider(key.name, key.slider_min, key.slider_max, key.relative_key.name, key.vertex_group)
            for key in mixed_keys.mixed(obj)
        ]
        super().__init__(obj, sliders)

    @staticmethod
    def signature(obj):
        keys = tuple((key.name, key.slider_min, key.slider_max, key.vertex_group) for key in mixed_keys.mixed(obj))
        return len(obj.data.vertices), keys, seams.signature(obj), mirrors.signature(obj)

    @staticmethod
    def written_key(obj):
        return key_marks.only(obj.data.shape_keys, Role.MIX)

    def result(self, obj):
        """The MixInput. @throws SceneError."""
        parts = self.parts(obj)
        rest, shapes, faces = parts["rest"], parts["points"], mesh_arrays.faces(obj.data)
        for name, shape in shapes.items():
            _require_extent(name, shape)
        welding.require_no_more_than_seams(rest, *faces, obj.meanvalue.merge_distance)
        copies = welding.together(seams.copies(obj, rest, faces), shapes.values(), obj.meanvalue.merge_distance)
        planes, twins = mirrors.doubling(obj, rest, *faces, shapes.values())
        triangles = mesh_arrays.triangles(obj.data, rest)
        return MixInput(**parts, triangles=triangles, copies=copies, planes=planes, twins=twins)


gather = MixReading.gather


def _require_extent(name, shape):
    if len(shape) == 0 or (shape == shape[0]).all():
        raise SceneError(
            f"Shape key '{name}' has {wording.vertices(len(shape))}, all in one place, so nothing can turn. Mute it, "
            "or give it a shape"
        )
