# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads motion capture files: one Empty for each marker, animated as it was recorded."""

import math
import pathlib

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from ... import compat, wording
from ...errors import MeanValueError, MotionFileError, SceneError
from ...scene import pose_objects, selection
from ...scene.core import sample_times
from ...widgets.base import Reporting
from ..bridge import takes
from ..core import readers, units

_FileHandler = compat.file_handler()

FROM_FILE = 'FILE'


class MEANVALUE_OT_import_motion(Reporting, ImportHelper, bpy.types.Operator):
    """Import markers of motion capture (C3D, TRC, BVH, CSV, TSV or JSON) as animated Empties"""

    bl_label = "Import Motion Capture"
    bl_options = {'REGISTER', 'UNDO', 'PRESET'}

    filter_glob: bpy.props.StringProperty(
        default=";".join(f"*{suffix};*{suffix.upper()}" for suffix in readers.SUFFIXES), options={'HIDDEN'}
    )
    filepath: bpy.props.StringProperty(subtype='FILE_PATH', options={'HIDDEN', 'SKIP_SAVE'})
    files: bpy.props.CollectionProperty(type=bpy.types.OperatorFileListElement, options={'HIDDEN', 'SKIP_SAVE'})
    directory: bpy.props.StringProperty(subtype='DIR_PATH', options={'HIDDEN', 'SKIP_SAVE'})
    up_axis: bpy.props.EnumProperty(
        name="Up Axis",
        description="Which axis of the file points up",
        items=[(FROM_FILE, "From File", "As the file says"), *((axis, axis, "") for axis in units.UP_AXES)],
        default=FROM_FILE,
    )
    unit: bpy.props.EnumProperty(
        name="Unit",
        description="What the file counts lengths in",
        items=(
            (FROM_FILE, "From File", "As the file says"),
            *((name.upper().replace("METERS", "METRES"), name, f"The file counts in {name.lower()}")
              for name in ("Meters", "Centimeters", "Millimeters", "Inches", "Feet")),
        ),
        default=FROM_FILE,
    )
    scale: bpy.props.FloatProperty(
        name="Scale", description="Factor on all positions", default=1.0, min=1e-6, soft_min=0.01, soft_max=100.0
    )
    time: bpy.props.EnumProperty(
        name="Time",
        description="How the samples are laid into the time of the scene. One second stays one second either way",
        items=(
            ('SCENE', "Keep Scene Rate", "Keys come between the frames where the capture has more samples a second"),
            ('CAPTURE', "Take Capture's Rate", "Set the scene's frame rate to that of the (first) file"),
        ),
        default='SCENE',
    )
    start_frame: bpy.props.IntProperty(name="Start Frame", description="Frame of the start of the recording", default=1)
    extend_range: bpy.props.BoolProperty(
        name="Extend Range", description="Have the scene play all frames of the take that show a marker", default=True
    )

    def invoke(self, context, event):
        if self.files and self.directory:  # dropped on the window
            return context.window_manager.invoke_props_dialog(self)
        return super().invoke(context, event)

    def execute(self, context):
        try:
            read = self._read()
            collections, frames = self._make(context.scene, read)
        except MeanValueError as error:
            return self.refuse(error)
        if self.extend_range:
            # The end moves out, the start past what is empty at the start of all.
            scene, spans = context.scene, [_seen_span(take) for take in read]
            begin = min(each[span[0]] for each, span in zip(frames, spans, strict=True))
            end = max(each[span[1]] for each, span in zip(frames, spans, strict=True))
            scene.frame_end = max(scene.frame_end, math.ceil(end))
            if scene.frame_start == self.start_frame < begin:
                scene.frame_start = math.ceil(begin)
        # A mesh that is being worked on stays active and gets the take, if it has none; else the markers are selected.
        active = pose_objects.of(context.object) or context.object
        if active is None or active.type != 'MESH':
            empties = [empty for collection in collections for empty in takes.markers(collection)]
            selection.choose(empties[0])
            for empty in empties:
                if empty.name in context.view_layer.objects:
                    empty.select_set(True)
        elif active.meanvalue.capture.take is None:
            active.meanvalue.capture.take = collections[0]
        for take, collection, times in zip(read, collections, frames, strict=True):
            self.tell(_account(take, collection, times), [])
        return {'FINISHED'}

    def _paths(self):
        """@throws SceneError if none is given."""
        folder = pathlib.Path(bpy.path.abspath(self.directory)) if self.directory else None
        named = [folder / each.name for each in self.files if each.name] if folder else []
        if named:
            return named
        if self.filepath:
            return [pathlib.Path(bpy.path.abspath(self.filepath))]
        raise SceneError(f"No file is chosen. Choose one or more of {wording.listed(readers.SUFFIXES)}")

    def _read(self):
        """The Takes of all files, before anything is made. @throws MotionFileError, SceneError."""
        unit = units.METRES.get(self.unit.lower())
        up_axis = None if self.up_axis == FROM_FILE else self.up_axis
        try:
            return [readers.read(path, up_axis=up_axis, unit=unit) for path in self._paths()]
        except MotionFileError as error:  # begins with the name of the file, which must stay as it is
            raise MotionFileError(f"Cannot import {error}") from error

    def _make(self, scene, read):
        """(collections, the frames of their samples); all of them or, after an error, none."""
        former = scene.render.fps, scene.render.fps_base
        made, frames = [], []
        try:
            if self.time == 'CAPTURE':
                scene.render.fps = max(1, round(read[0].rate_hz))
                scene.render.fps_base = scene.render.fps / read[0].rate_hz
                rate = read[0].rate_hz  # the scene's own figure is rounded to single precision
            else:
                rate = scene.render.fps / scene.render.fps_base
            for take in read:
                samples = round(take.start_s * take.rate_hz) + np.arange(take.frames)
                frames.append(self.start_frame + samples * (rate / take.rate_hz))  # fractional ones, too
                made.append(takes.make(take, frames[-1], self.scale))
        except BaseException:
            scene.render.fps, scene.render.fps_base = former
            for collection in made:
                takes.remove(collection)
            raise
        return made, frames


def _seen_span(take):
    """(first, last): numbers of the samples that show any marker."""
    seen = take.measured.any(axis=1).nonzero()[0]
    return int(seen[0]), int(seen[-1])


def _account(take, collection, frames):
    """What was read of one file, in numbers: sentences."""
    first, last = (frames[number] for number in _seen_span(take))
    gaps = sum(len(sample_times.runs(~column)) for column in take.measured.T)
    kinds = wording.listed(f"{len(names):,} {kind}" for kind, names in take.left_out.items())
    return [
        f"'{collection.name}': {wording.counted(len(takes.markers(collection)), 'marker')}, "
        f"{wording.counted(take.frames, 'sample')}, {(take.frames - 1) / take.rate_hz:.2f} s at {take.rate_hz:g} Hz",
        *([f"The file starts {take.start_s:g} s into its recording"] if take.start_s else []),
        f"Markers are seen from frame {first:g} to {last:g}",
        f"{wording.counted(gaps, 'gap')} ({wording.share(take.missing_share)} of the samples)" if gaps else "No gaps",
        *([f"Left out, since they are no markers: {kinds}"] if kinds else []),
        *take.notes,
    ]


if _FileHandler is not None:

    class MEANVALUE_FH_motion(_FileHandler):
        """Imports files that are dropped on a 3D View, where Blender can do that (4.1 and later)"""

        bl_idname = "MEANVALUE_FH_motion"
        bl_label = "Motion Capture"
        bl_import_operator = MEANVALUE_OT_import_motion.bl_idname
        bl_file_extensions = ";".join(readers.SUFFIXES)

        @classmethod
        def poll_drop(cls, context):
            return context.area is not None and context.area.type == 'VIEW_3D'
