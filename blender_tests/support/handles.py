# SPDX-License-Identifier: GPL-3.0-or-later
"""A tube with a pin at its lower and a handle at its upper end, as an artist sets it up."""

import bpy
import numpy as np

from . import meshes, steps

RINGS, SEGMENTS = 17, 8
BOTTOM = range(SEGMENTS)
MIDDLE = range(RINGS // 2 * SEGMENTS, (RINGS // 2 + 1) * SEGMENTS)
TOP = range((RINGS - 1) * SEGMENTS, RINGS * SEGMENTS)
RESULT = "Mean-Value"


def tube(name="Tube", live=True, middle=False):
    """(object, control) with the control active, as Add Handle leaves it. middle: with a second pin there."""
    obj = meshes.tube(RINGS, SEGMENTS, name)
    steps.add_handle(obj, "Bottom", BOTTOM, pin=True)
    if middle:
        steps.add_handle(obj, "Middle", MIDDLE, pin=True)
    steps.add_handle(obj, "Top", TOP, live=live)
    update()
    return obj, bpy.context.object


def again(name="Tube"):
    """The object as it is now: references do not survive undo."""
    return bpy.data.objects[name]


def three_handles(live=True):
    """(object, control of Top, vertices of Middle)."""
    return (*tube(live=live, middle=True), MIDDLE)


def update():
    """What Blender does after every event: evaluate what was changed, and tell the handlers."""
    bpy.context.view_layer.update()


def move(control, offset):
    control.location = [a + b for a, b in zip(control.location, offset, strict=True)]
    update()


def shown(obj):
    """n x 3 float32 of the result."""
    return steps.key_positions(obj, RESULT)


def rest(obj):
    return steps.key_positions(obj, "Basis")


def follows(obj, offset, vertices=TOP):
    """Whether these vertices are shown by `offset` off their rest."""
    return float(np.abs(shown(obj)[vertices] - rest(obj)[vertices] - np.array(offset, np.float32)).max()) < 1e-3


def is_at_rest(obj, tolerance=1e-5):
    return bool(np.abs(shown(obj) - rest(obj)).max() < tolerance)


def assert_reset_puts_at_rest(obj):
    steps.run(obj, "reset_handles")
    update()
    assert is_at_rest(obj, 1e-3), np.abs(shown(obj) - rest(obj)).max()
