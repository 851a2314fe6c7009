# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be baked besides handles: rooms append to `kinds`, baking asks of(obj). Baking itself knows none of them.

A kind is a module, or an object, with these functions:

is_meant(obj)   whether it is this that shapes `obj`, or whose bake plays in its place: cheap
bind(obj)       in place of a Posing: bind_input (with rest, diagonal and revision, a digest of it), binding,
                record(), work(), require_unchanged(). @throws SceneError
row(obj, bind_input)
                (k,) float64: what the shape at the frame that is current depends on. @throws SceneError
solve_steps(binding, bind_input, row, execution)
                steps (see solver/job.py) to one shape, with positions (n x 3) and converged.
                @throws SolverError, CancelledError
shown_keys(obj) the shape keys that show it, to be muted while the bake plays
animated(obj)   the datablocks whose keyframes move it
is_on(obj), turn(obj, is_on)
                whether the mesh follows it at once, and the switch of that
"""

kinds = []


def of(obj):
    """The kind that is meant, or None: then it is the handles."""
    return next((kind for kind in kinds if kind.is_meant(obj)), None)
