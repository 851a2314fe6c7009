# SPDX-License-Identifier: GPL-3.0-or-later
"""Symmetric and Mirror at the interface: a drag by the mouse keeps both sides alike, in every step.

./dev test --only ui -k symmetry
"""

import bpy
import numpy as np
from support import halves


def _drag(ui, obj, control, picture, off):
    """By the mouse; off(): how far both sides are from being alike."""
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    bpy.context.view_layer.objects.active = control
    control.select_set(True)
    seen = []
    yield from ui.drag_by_keys('G', 60, 40, between=lambda step: seen.append(off()))
    yield from ui.wait_until(lambda: np.abs(halves.shown(obj) - halves.rest(obj)).max() > 0.05, "the mesh to follow")
    assert max(seen) < 1e-6 and off() < 1e-6
    yield from ui.screenshot(picture)


def symmetric_while_dragging(ui):
    obj, control = halves.whole()
    obj.meanvalue.symmetric = 'X'
    yield from _drag(ui, obj, control, "symmetric", lambda: halves.asymmetry(obj, halves.shown(obj)))


def seam_while_dragging(ui):
    obj, control = halves.half()
    seam = halves.seam(obj)
    yield from _drag(ui, obj, control, "mirror_seam", lambda: np.abs(halves.shown(obj)[seam, 0]).max())
