# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads values of shapes by name, as recorders of faces write them, onto shape keys of the same names."""

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from ... import wording
from ...errors import MotionFileError, SceneError
from ...widgets.base import MeshOperator
from ..bridge import value_curves
from ..core import key_names, value_files


class MEANVALUE_OT_import_values(MeshOperator, ImportHelper, bpy.types.Operator):
    """Read values by name (CSV or JSON of a face recorder) onto shape keys of these names, from the current frame on"""

    bl_label = "Import Shape Key Values"
    bl_options = {'REGISTER', 'UNDO', 'PRESET'}
    needs_object_mode = False
    problems = (value_curves.problem,)

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
        found = key_names.matched(recorded.names, names, self.names)
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
        notes = value_curves.write(obj, curves, self.replace)
        rows = wording.counted(len(recorded.times), "frame")
        told = [f"Read {rows} of {wording.counted(len(curves), 'shape key')} onto '{obj.name}'", recorded.clock]
        keyless = [name for name in recorded.names if name not in found]
        if keyless:
            told.append(f"No shape key for {wording.quoted(keyless, limit=12)}")
        return told, [*recorded.notes, *notes]
