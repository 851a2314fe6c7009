# SPDX-License-Identifier: GPL-3.0-or-later
"""What should be looked at in a take: listed, and swapped markers mended."""

import bpy
import numpy as np

from ... import wording
from ...errors import SceneError
from ...scene.core import sample_times
from ...widgets.base import MeshOperator
from ..bridge import marker_pairs, takes
from ..core import jumps

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
    longest = 1.0 if obj is None else max(obj.meanvalue.capture.spline_seconds, obj.meanvalue.capture.rigid_seconds)
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
