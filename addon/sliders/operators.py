# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds values of shape keys and reads them, keys them, and puts what they do not reach into one more shape key."""

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from .. import wording
from ..baking.properties import chosen
from ..errors import MotionFileError, SceneError
from ..live import engine
from ..posing.bridge import scene_input, targets
from ..widgets.background import BackgroundOperator
from ..widgets.base import MeshOperator
from . import properties
from .bridge import driven_keys, key_shapes, value_baking
from .bridge.driven_keys import Corrective
from .core import value_files


class MEANVALUE_OT_add_corrective(BackgroundOperator, bpy.types.Operator):
    """Put what the sliders do not reach into one more shape key, Corrective, with which all handles are met"""

    bl_label = "Add Corrective"
    doing = "Finding the corrective of"
    problems = (driven_keys.problem, key_shapes.problem, scene_input.unheld_problem, targets.problem)

    def prepare(self, obj):
        if obj.meanvalue.live and not engine.is_settled(obj):
            raise SceneError("The sliders still follow the handles. Try again when they are there")
        return Corrective(obj)

    def finish(self, obj, prepared, outcome):
        return f"Shape key '{prepared.write(obj, outcome[0])}' of '{obj.name}' adds what sliders do not reach", []


class MEANVALUE_OT_import_values(MeshOperator, ImportHelper, bpy.types.Operator):
    """Read values by name (CSV or JSON of a face recorder) onto shape keys of these names, from the current frame on"""

    bl_label = "Import Shape Key Values"
    bl_options = {'REGISTER', 'UNDO', 'PRESET'}
    needs_object_mode = False
    problems = (key_shapes.curves_problem,)

    filter_glob: bpy.props.StringProperty(
        default=";".join(f"*{suffix};*{suffix.upper()}" for suffix in value_files.SUFFIXES), options={'HIDDEN'}
    )
    names: bpy.props.StringProperty(
        name="Names",
        description="For names that differ: name in the file = shape key; and so on. Nothing behind = leaves one out",
    )
    rate: bpy.props.FloatProperty(
        name="Rate",
        description="Frames a second of the recording. 0: as the file tells, else one row a frame of the scene",
        min=0.0,
        soft_max=120.0,
        options={'SKIP_SAVE'},
    )
    scale: bpy.props.FloatProperty(
        name="Scale", description="Factor on all values: 0.01 for those that are percentages", default=1.0
    )
    replace: bpy.props.BoolProperty(
        name="Replace", description="Write over values that are animated already", options={'SKIP_SAVE'}
    )

    def run(self, obj):
        if not self.filepath:
            raise SceneError(f"No file is chosen. Choose one of {wording.listed(value_files.SUFFIXES)}")
        try:
            recorded = value_files.read(bpy.path.abspath(self.filepath), self.rate or None)
        except MotionFileError as error:  # begins with the name of the file, which must stay as it is
            raise MotionFileError(f"Cannot import {error}") from error
        keys = obj.data.shape_keys
        names = [key.name for key in keys.key_blocks if key != keys.reference_key]
        found = value_files.matched(recorded.names, names, self.names)
        scene, curves = bpy.context.scene, {}
        rate = scene.render.fps / scene.render.fps_base
        frames = scene.frame_current + recorded.times * (rate / recorded.rate_hz if recorded.rate_hz else 1.0)
        for name, values in zip(recorded.names, recorded.values.T, strict=True):
            present = ~np.isnan(values)
            if name in found and present.any():
                curves[found[name]] = frames[present], self.scale * values[present]
        if not curves:
            raise SceneError(
                f"No shape key of '{obj.name}' has a name of the file ({wording.quoted(recorded.names)}). Say in Names "
                "which belong together"
            )
        notes = key_shapes.write(obj, curves, self.replace)
        rows = wording.counted(len(recorded.times), "frame")
        told = [f"Read {rows} of {wording.counted(len(curves), 'shape key')} onto '{obj.name}'", recorded.clock]
        keyless = [name for name in recorded.names if name not in found]
        if keyless:
            told.append(f"No shape key for {wording.quoted(keyless, limit=12)}")
        return told, [*recorded.notes, *notes]


class MEANVALUE_OT_bake_values(BackgroundOperator, bpy.types.Operator):
    """Find the values of the shape keys with which the face follows its handles or markers, and key them"""

    bl_label = "Bake Shape Key Values"
    doing = "Baking values of"
    problems = (key_shapes.curves_problem, value_baking.problem)

    __annotations__ = dict(properties.OPTIONS)

    def prepare(self, obj):
        options = chosen(self, obj.meanvalue.bake_values, properties.OPTIONS)
        return value_baking.ValueBaking(obj, bpy.context.scene, options)

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
