# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetric and Mirror at the interface: a drag by the mouse keeps both sides alike, in every step.

    ./dev test --only ui -k symmetry
"""

import bpy
import numpy as np
from support import halves


def _center_of(control):
    bpy.context.view_layer.objects.active = control
    control.select_set(True)


def symmetric_while_dragging(ui):
    obj, control = halves.whole()
    obj.meanvalue.symmetric = 'X'
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    _center_of(control)
    seen = []
    yield from ui.drag_by_keys('G', 60, 40, between=lambda step: seen.append(halves.asymmetry(obj, halves.shown(obj))))
    yield from ui.wait_until(lambda: np.abs(halves.shown(obj) - halves.rest(obj)).max() > 0.05, "the mesh to follow")
    assert max(seen) < 1e-6 and halves.asymmetry(obj, halves.shown(obj)) < 1e-6
    yield from ui.screenshot("symmetric")


def seam_while_dragging(ui):
    obj, control = halves.half()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    _center_of(control)
    seam = halves.seam(obj)
    seen = []
    yield from ui.drag_by_keys('G', 60, 40, between=lambda step: seen.append(halves.shown(obj)[seam, 0]))
    yield from ui.wait_until(lambda: np.abs(halves.shown(obj) - halves.rest(obj)).max() > 0.05, "the mesh to follow")
    assert np.abs(seen).max() < 1e-6 and np.abs(halves.shown(obj)[seam, 0]).max() < 1e-6
    yield from ui.screenshot("mirror_seam")
