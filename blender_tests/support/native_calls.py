# SPDX-License-Identifier: GPL-3.0-or-later
"""A tube to call the native module with, and a call that is cancelled half-way."""

import threading
import time

import meanvalue
import numpy as np

from . import rings


def tube(around=12, along=15):
    """An open tube: vertices (n, 3) and triangles (m, 3)."""
    angle_rad = 2 * np.pi * np.arange(around) / around
    circle = np.stack([np.cos(angle_rad), np.sin(angle_rad)], axis=1)
    vertices = np.array([[x, y, 0.5 * level] for level in range(along) for x, y in circle])
    return vertices, rings.triangles(rings.quads(along, around))


VERTICES, TRIANGLES = tube()
ENDS = np.r_[0:12, 168:180]


def bent_targets():
    """The upper end turned by 60 degrees about x and moved."""
    cos, sin = np.cos(np.pi / 3), np.sin(np.pi / 3)
    turn = np.array([[1, 0, 0], [0, cos, -sin], [0, sin, cos]])
    targets = VERTICES[ENDS].copy()
    targets[12:] = (targets[12:] - [0, 0, 7]) @ turn.T + [0, -2, 6]
    return targets


def cancelled_while_solving(call):
    """Runs call(execution) on a thread and cancels it in its stage "solve". Whether it ended by Cancelled.

    That stage is seen only where the call has released the interpreter.
    """
    execution = meanvalue.Execution()
    outcome = []

    def work():
        try:
            outcome.append(call(execution))
        except meanvalue.Cancelled:
            outcome.append("cancelled")

    thread = threading.Thread(target=work)
    thread.start()
    while execution.stage != "solve" and thread.is_alive():
        time.sleep(0.001)
    execution.cancel()
    thread.join()
    assert execution.cancelled
    return isinstance(outcome[0], str)


def bound(bind_input, triangles):
    """A Deformer of a BindInput, as session.bind_steps() makes it."""
    whole = bind_input.solver_mesh
    return meanvalue.Deformer(
        whole.rest,
        whole.triangles(triangles),
        whole.anchors,
        roi=None if whole.roi.all() else whole.roi,
        handles=whole.handles,
        rigidity=bind_input.rigidity,
        strengths=whole.strengths,
        loose=bind_input.loose,
    )
