# SPDX-License-Identifier: GPL-3.0-or-later
"""What Solve and Solve from Shape Key have in common."""

from ...scene import rig_space, shape_keys, subject
from ...solver.core import result
from ...widgets.background import BackgroundOperator
from ..bridge import bound_record


class SolvingOperator(BackgroundOperator):
    """Mix-in: finish() for subclasses whose prepare() gives a Posing with targets."""

    doing = "Solving"

    def finish(self, obj, posing, outcome):
        solved, summary = outcome
        positions = posing.targets.positions
        warnings = [
            *posing.binding.summary.notes(),
            *summary.notes(),
            *result.pose_warnings(posing.bind_input, positions),
        ]
        if rig_space.note(obj):
            warnings.append(rig_space.note(obj))
        notes = shape_keys.write_result(obj, result.compose(posing.bind_input, positions, solved))
        posing.keep()
        if posing.changes:
            if obj.meanvalue.bound.is_bound:
                notes.insert(0, f"Bound again, because {posing.changes}")
            posing.record(obj)
        bound_record.write_solve(obj.meanvalue.bound, summary)
        shared = subject.sharing_note(obj)
        solved_into = f"Solved into '{obj.meanvalue.result_key}': {summary.text()}"
        return ". ".join([solved_into, *notes, *([shared] if shared else [])]), warnings
