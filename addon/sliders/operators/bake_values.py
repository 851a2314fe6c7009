# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds values of the shape keys that a mesh has by its handles or by markers, and keys them."""

import bpy

from ...baking.properties import chosen, unsaved
from ...live import engine
from ...widgets.background import BackgroundOperator
from .. import properties
from ..bridge import value_baking, value_curves


class MEANVALUE_OT_bake_values(BackgroundOperator, bpy.types.Operator):
    """Find the values of the shape keys with which the face follows its handles or markers, and key them"""

    bl_label = "Bake Shape Key Values"
    doing = "Baking values of"
    problems = (value_curves.problem, value_baking.problem)

    __annotations__ = unsaved(properties.OPTIONS)

    def prepare(self, obj):
        return value_baking.ValueBaking(obj, bpy.context.scene, self._options(obj))

    def before(self, prepared):
        with engine.held():
            for share in prepared.source.sample(self.object):
                yield "sampling the animation", share

    def after(self, prepared):
        for share in prepared.reduce():
            yield "choosing the keyframes", share

    def finish(self, obj, prepared, _outcome):
        notes = prepared.write(obj)
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        return prepared.account(obj), notes

    def _options(self, obj):
        return chosen(self, obj.meanvalue.bake_values, properties.OPTIONS)
