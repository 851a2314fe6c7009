# SPDX-License-Identifier: GPL-3.0-or-later
"""Lists what should be looked at in a take."""

import bpy
import numpy as np

from ... import wording
from ...errors import MeanValueError
from ...scene.core import sample_times
from ...widgets.base import Reporting
from ..bridge import takes
from ..core import jumps

#: Gaps that are too long for their thresholds are all listed; of jumps, so many. More would not be read.
MOST = 200


class TakeOperator(Reporting):
    """Mix-in for operators on the take that the artist works on. Subclasses define run(context, take)."""

    bl_options = {'REGISTER', 'UNDO'}

    @classmethod
    def poll(cls, context):
        if takes.chosen(context) is None:
            cls.poll_message_set("No take is chosen. Import a motion capture file, or click one of its markers")
            return False
        return True

    def execute(self, context):
        try:
            message, warnings = self.run(context, takes.chosen(context))
        except MeanValueError as error:
            return self.refuse(error)
        return self.tell(message, warnings)


class MEANVALUE_OT_find_marker_problems(TakeOperator, bpy.types.Operator):
    """List markers of the take that jump or are swapped with others, and gaps that are too long to be filled"""

    bl_idname = "meanvalue.find_marker_problems"
    bl_label = "Find Problems"

    def run(self, context, take):
        recording = takes.read(take)
        is_skeleton = take.meanvalue.is_skeleton
        found = jumps.find_jumps(recording.positions, recording.rate_hz, recording.labels, is_skeleton)
        found = [(each.sample, each.marker, each.words, each.other) for each in found]
        longest = _longest_gap(context, take)
        found += _gaps(recording, longest)
        settings = take.meanvalue
        settings.problems.clear()
        settings.is_searched = True
        for sample, marker, text, other in sorted(found, key=lambda each: each[:3])[:MOST]:
            problem = settings.problems.add()
            problem.text = text
            problem.marker = recording.empties[marker]
            problem.other = None if other is None else recording.empties[other]
            problem.frame = recording.frames[sample]
        if not found:
            return f"'{take.name}': no jumps, no swapped markers, no gaps over {longest:g} s", []
        more = [f"The first {MOST} are listed"] if len(found) > MOST else []
        first = settings.problems[0]
        return (
            f"'{take.name}': {wording.counted(len(found), 'problem')} found. The first, at frame {first.frame:g}: "
            f"{first.text.rstrip('.')}. Click one in the list to go there",
            more,
        )


def _gaps(recording, longest):
    for marker, label in enumerate(recording.labels):
        for begin, end in sample_times.runs(np.isnan(recording.positions[:, marker, 0])):
            seconds = (end - begin) / recording.rate_hz
            if seconds > longest:
                yield int(begin), marker, f"{label} is missing for {seconds:.2f} s", None


def _longest_gap(context, take):
    """Seconds: what the mesh that uses the take fills."""
    for obj in context.view_layer.objects:
        if obj.type == 'MESH' and obj.meanvalue.capture.take == take:
            capture = obj.meanvalue.capture
            return max(capture.spline_seconds, capture.rigid_seconds)
    return 1.0
