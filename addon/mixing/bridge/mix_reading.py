# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the shape keys that are mixed."""

from ...errors import SceneError
from ...scene import key_marks, mesh_arrays, mirrors, seams
from ...scene.core import welding
from ...scene.key_marks import Role
from ...scene.key_reading import KeyReading, slider_of
from ..core.mix_input import MixInput
from . import mixed_keys


class MixReading(KeyReading):
    """A kind of reading as scene/object_model.py wants it, of MixInputs."""

    def __init__(self, obj):
        found = mixed_keys.problem(obj)
        if found:
            raise SceneError(found)
        super().__init__(obj, _sliders(obj))

    @staticmethod
    def signature(obj):
        return len(obj.data.vertices), _sliders(obj), seams.signature(obj), mirrors.signature(obj)

    @staticmethod
    def written_key(obj):
        return key_marks.only(obj.data.shape_keys, Role.MIX)

    def result(self, obj):
        """The MixInput. @throws SceneError."""
        parts = self.parts(obj)
        rest, shapes, faces = parts["rest"], parts["points"], mesh_arrays.faces(obj.data)
        welding.require_no_more_than_seams(rest, *faces, obj.meanvalue.merge_distance)
        copies = welding.together(seams.copies(obj, rest, faces), shapes.values(), obj.meanvalue.merge_distance)
        planes, twins = mirrors.doubling(obj, rest, *faces, shapes.values())
        triangles = mesh_arrays.triangles(obj.data, rest)
        return MixInput(**parts, triangles=triangles, copies=copies, planes=planes, twins=twins)


gather = MixReading.gather


def _sliders(obj):
    return [slider_of(obj, key) for key in mixed_keys.mixed(obj)]
