# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads motion capture files: one Empty for each marker, animated as it was recorded. What should be looked at in such
a take is listed, and swapped markers mended."""

import math
import pathlib

import bpy
import numpy as np
from bpy_extras.io_utils import ImportHelper

from ... import compat, wording
from ...errors import MeanValueError, MotionFileError, SceneError
from ...scene import pose_objects, subject
from ...scene.core import sample_times
from ...widgets.base import MeshOperator, Reporting
from ..bridge import marker_pairs, takes
from ..core import jumps, readers, units

_FileHandler = compat.file_handler()

FROM_FILE, UNITS = 'FILE', ("Meters", "Centimeters", "Millimeters", "Inches", "Feet")


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
            *((each.upper().replace("TERS", "TRES"), each, f"The file counts in {each.lower()}") for each in UNITS),
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
        seen, scene = [each[take.measured.any(axis=1)] for take, each in zip(read, frames, strict=True)], context.scene
        if self.extend_range:
            # The end moves out, the start past what is empty at the start of all.
            scene.frame_end = max(scene.frame_end, *(math.ceil(each[-1]) for each in seen))
            begin = math.ceil(min(each[0] for each in seen))
            scene.frame_start = begin if scene.frame_start == self.start_frame < begin else scene.frame_start
        # A mesh that is being worked on stays active and gets the take, if it has none; else the markers are selected.
        active = pose_objects.of(context.object) or context.object
        if active is None or active.type != 'MESH':
            empties = [empty for collection in collections for empty in takes.markers(collection)]
            subject.choose(empties[0])
            for empty in empties:
                if empty.name in context.view_layer.objects:
                    empty.select_set(True)
        elif active.meanvalue.capture.take is None:
            active.meanvalue.capture.take = collections[0]
        for take, collection, times in zip(read, collections, seen, strict=True):
            self.tell(_account(take, collection, times), [])
        return {'FINISHED'}

    def _paths(self):
        """@throws SceneError if none is given."""
        folder = pathlib.Path(bpy.path.abspath(self.directory))
        named = [folder / each.name for each in self.files if each.name and self.directory]
        if not (named or self.filepath):
            raise SceneError(f"No file is chosen. Choose one or more of {wording.listed(readers.SUFFIXES)}")
        return named or [pathlib.Path(bpy.path.abspath(self.filepath))]

    def _read(self):
        """The Takes of all files, before anything is made. @throws MotionFileError, SceneError."""
        unit = units.METRES.get(self.unit.lower())
        up_axis = None if self.up_axis == FROM_FILE else self.up_axis
        found, along = [], set()  # files of one frame each are one take
        try:
            for path in self._paths():
                if path not in along:
                    found.append(readers.read(path, up_axis=up_axis, unit=unit, along=along))
            return found
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


def _account(take, collection, seen):
    """What was read of one file, in numbers: sentences. seen: frames of the scene that show any marker."""
    gaps = sum(len(sample_times.runs(~column)) for column in take.measured.T)
    kinds = wording.listed(f"{len(names):,} {kind}" for kind, names in take.left_out.items())
    return [
        f"'{collection.name}': {wording.counted(len(takes.markers(collection)), 'marker')}, "
        f"{wording.counted(take.frames, 'sample')}, {(take.frames - 1) / take.rate_hz:.2f} s at {take.rate_hz:g} Hz",
        *([f"The file starts {take.start_s:g} s into its recording"] if take.start_s else []),
        f"Markers are seen from frame {seen[0]:g} to {seen[-1]:g}",
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


#: Gaps that are too long for their thresholds are all listed; of jumps, so many. More would not be read.
MOST = 200


class TakeOperator(MeshOperator):
    """Mix-in for operators on the take that the artist works on."""

    worked_on = staticmethod(takes.chosen)

    @classmethod
    def problem(cls, take):
        return "No take is chosen. Import a motion capture file, or click one of its markers" if take is None else None


class MEANVALUE_OT_find_marker_problems(TakeOperator, bpy.types.Operator):
    """List markers of the take that jump or are swapped with others, and gaps that are too long to be filled"""

    bl_label = "Find Problems"

    def run(self, take):
        count, longest = _list_problems(take)
        if not count:
            return f"'{take.name}': no jumps, no swapped markers, no gaps over {longest:g} s", []
        first = take.meanvalue.problems[0]
        return (
            f"'{take.name}': {wording.counted(count, 'problem')} found. The first, at frame {first.frame:g}: "
            f"{first.text.rstrip('.')}. Click one in the list to go there",
            [f"The first {MOST} are listed"] if count > MOST else [],
        )


class MEANVALUE_OT_swap_markers(TakeOperator, bpy.types.Operator):
    """Exchange the paths of the two markers of the active problem, from its frame to the end of the take"""

    bl_label = "Swap Markers"

    def run(self, take):
        problem = takes.active_problem(take.meanvalue)
        if problem is None or not {problem.marker, problem.other}.issubset(takes.markers(take)):
            raise SceneError("No swapped pair is chosen. Press Find Problems and choose one of the list")
        one, other, frame = problem.marker.meanvalue.marker, problem.other.meanvalue.marker, problem.frame
        takes.swap(take, problem.marker, problem.other, frame)
        _list_problems(take)
        return (
            f"'{one}' and '{other}' have changed places from frame {frame:g} on. What is matched already follows after "
            "Match Markers",
            [],
        )


def _list_problems(take):
    """(how many problems a take has, of how many seconds gaps are none: what the mesh that uses it fills). The first
    MOST are on its list."""
    recording, obj = takes.read(take), marker_pairs.mesh_of_take(take)
    longest = 1.0 if obj is None else obj.meanvalue.capture.rigid_seconds
    found = jumps.find_jumps(recording.positions, recording.rate_hz, recording.labels, take.meanvalue.is_skeleton)
    found = [(each.sample, each.marker, each.words, each.other) for each in found]
    for marker, label in enumerate(recording.labels):
        for begin, end in sample_times.runs(np.isnan(recording.positions[:, marker, 0])):
            seconds = (end - begin) / recording.rate_hz
            if seconds > longest:
                found.append((int(begin), marker, f"{label} is missing for {seconds:.2f} s", None))
    take.meanvalue.problems.clear()
    take.meanvalue.is_searched = True
    for sample, marker, text, other in sorted(found, key=lambda each: each[:3])[:MOST]:
        problem = take.meanvalue.problems.add()
        problem.text = text
        problem.marker = recording.empties[marker]
        problem.other = None if other is None else recording.empties[other]
        problem.frame = recording.frames[sample]
    return len(found), longest
