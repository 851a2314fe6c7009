# SPDX-License-Identifier: GPL-3.0-or-later
"""Stops a bake on its way, inside a chunk."""

import contextlib
import time


@contextlib.contextmanager
def pausing_at(solving, share):
    """Inside, what bake.solving solves is paused once so much of a chunk is solved, as by Esc. Yields the list of
    (begin, end, whether it went on from what was kept)."""
    solve, asked = solving.solve_rows, []

    def paused(binding, bind_input, targets, weights, begin, end, execution, threads=0, resume=None):
        asked.append((begin, end, resume is not None))
        steps = solve(binding, bind_input, targets, weights, begin, end, execution, threads, resume)
        task = next(steps)
        while not task.finished and execution.progress < share:
            time.sleep(0.0002)
        if share < 1.0:
            execution.pause()
        yield task
        return (yield from steps)

    solving.solve_rows = paused
    try:
        yield asked
    finally:
        solving.solve_rows = solve
