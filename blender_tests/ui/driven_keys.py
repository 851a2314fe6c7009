# SPDX-License-Identifier: GPL-3.0-or-later
"""Drive: Shape Keys. A handle is dragged with the mouse: the slider goes along, and everything can be taken back."""

import bpy
import numpy as np
from support import meshes, steps
from support.interface import is_settled

CORNERS, LIP = [0, 8, 72, 80], [38, 39, 47, 48]


def face():
    """Looked up on every call: references do not survive undo."""
    return bpy.data.objects["Grid"]


def value():
    return face().data.shape_keys.key_blocks["Side"].value


def control():
    return face().meanvalue.handles["Lip"].control


def _settled():
    return is_settled(face())


def _set_up(ui):
    """A pinned grid with a key that moves its middle to the side, a handle there, and a look from above."""
    obj = meshes.grid(9, 9)
    obj.name = "Grid"
    rest = np.array([tuple(vertex.co) for vertex in obj.data.vertices])
    near = np.exp(-((rest - rest[LIP].mean(axis=0)) ** 2).sum(axis=1) / 4.0)[:, None]
    steps.add_key(obj, "Side", rest + near * np.array([2.0, 0.0, 0.0]))
    steps.list_anchors(obj, Corners=CORNERS)
    obj.meanvalue.drive = 'SHAPE_KEYS'
    ui.remember()
    yield from ui.open_tab("Mean-Value")
    meshes.activate(obj)
    steps.add_handle(obj, "Lip", LIP)
    yield from ui.key('NUMPAD_7')
    ui.frame_all()
    yield from ui.wait_until(_settled, "the keys are bound and at rest")
    ui.remember()
    assert abs(value()) < 1e-3


def a_dragged_handle_moves_a_slider(ui):
    yield from _set_up(ui)
    seen = []

    def look(_step):
        yield from ui.wait_until(lambda: value() > (seen[-1] if seen else 0.0) + 0.01, "the slider follows mid-drag")
        seen.append(value())

    yield from ui.drag_by_keys('G', 40, 0, between=look, end=None)
    yield from ui.screenshot("driven_1_mid_drag", amid_work=True)
    yield from ui.key('RET')
    yield from ui.wait_until(_settled, "the drag is settled")
    dropped = value()
    assert dropped >= seen[-1] - 1e-3
    assert face().meanvalue.result_key not in face().data.shape_keys.key_blocks

    yield from ui.undo()
    yield from ui.wait_until(_settled, "the undo is settled")
    assert abs(value()) < 1e-3
    yield from ui.redo()
    yield from ui.wait_until(_settled, "the redo is settled")
    assert abs(value() - dropped) < 1e-3


def esc_takes_the_slider_back(ui):
    yield from _set_up(ui)
    place = np.array(control().location)
    yield from ui.drag_by_keys('G', 40, 0, end=None)
    yield from ui.wait_until(lambda: value() > 0.05, "the slider follows")
    yield from ui.key('ESC')
    yield from ui.wait_until(lambda: _settled() and abs(value()) < 1e-3, "the slider is back")
    assert np.abs(np.array(control().location) - place).max() < 1e-6
