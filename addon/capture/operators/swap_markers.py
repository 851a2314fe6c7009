# SPDX-License-Identifier: GPL-3.0-or-later
"""Gives two markers of a take each other's path, where the capturing program took one for the other."""

import bpy

from ...errors import SceneError
from ..bridge import takes
from .find_marker_problems import TakeOperator


class MEANVALUE_OT_swap_markers(TakeOperator, bpy.types.Operator):
    """Exchange the paths of two markers from a frame to the end of the take, or in all of it"""

    bl_idname = "meanvalue.swap_markers"
    bl_label = "Swap Markers"
    bl_options = {'REGISTER', 'UNDO'}

    marker: bpy.props.StringProperty(
        name="Marker",
        description="Name of one of them. If empty: those and the frame of the active problem",
        options={'SKIP_SAVE'},
    )
    other: bpy.props.StringProperty(name="Other", description="Name of the other one", options={'SKIP_SAVE'})
    frame: bpy.props.FloatProperty(
        name="From Frame", description="From this frame of the scene on, with it", options={'SKIP_SAVE'}
    )
    whole_take: bpy.props.BoolProperty(
        name="Whole Take", description="In all frames: as if their names were exchanged", options={'SKIP_SAVE'}
    )

    def run(self, _context, take):
        problems = take.meanvalue.problems
        if not self.marker and not self.other:
            self._take_over(take, problems)
        empties = {empty.meanvalue.marker: empty for empty in takes.markers(take)}
        for name in (self.marker, self.other):
            if name not in empties:
                raise SceneError(f"'{name}' is no marker of '{take.name}'. Give the names of two of its markers")
        if self.marker == self.other:
            raise SceneError(f"'{self.marker}' can't be swapped with itself. Give the names of two markers")
        one, other = empties[self.marker], empties[self.other]
        takes.swap(take, one, other, None if self.whole_take else self.frame)
        if not self.whole_take:
            self._forget(take, one, other)
        where = "in the whole take" if self.whole_take else f"from frame {self.frame:g} on"
        return (
            f"'{self.marker}' and '{self.other}' have changed places {where}. What is matched already follows after "
            "Match Markers",
            [],
        )

    def _take_over(self, take, problems):
        active = take.meanvalue.active_problem
        problem = problems[active] if 0 <= active < len(problems) else None
        if problem is None or problem.marker is None or problem.other is None:
            raise SceneError(
                "No swapped pair is chosen. Press Find Problems and choose one of the list, or give the names of two "
                "markers"
            )
        self.marker, self.other = problem.marker.meanvalue.marker, problem.other.meanvalue.marker
        self.frame = problem.frame

    def _forget(self, take, one, other):
        """Takes the problem that is solved off the list."""
        problems = take.meanvalue.problems
        spacing = take.meanvalue.frames_per_sample
        for index, problem in enumerate(problems):
            is_pair = {problem.marker, problem.other} == {one, other}
            if is_pair and abs(problem.frame - self.frame) < 0.5 * spacing:
                problems.remove(index)
                break
