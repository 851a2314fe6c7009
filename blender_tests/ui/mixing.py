# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that turn, in Properties: switched on, dragged, baked to in-between keys, stopped by Esc, undone."""

import bpy
import numpy as np
from harness import view
from support import bent_limb, meshes, steps
from support.interface import is_settled
from support.snapshot import assert_same, snapshot

MIX = "Rotation-Aware Mix"


def limb():
    """Looked up on every call: references do not survive undo."""
    return bpy.data.objects["Limb"]


def keys():
    return limb().data.shape_keys.key_blocks


def settled():
    return is_settled(limb())


def shape():
    """n x 3: what turns the mix."""
    return np.array([point.co for point in keys()[MIX].data])


def _length():
    """Of the limb's axis: a turn keeps it, straight lines do not."""
    points = meshes.seen(limb())
    rings = points[: len(points) // 12 * 12].reshape(-1, 12, 3).mean(axis=1)
    return np.linalg.norm(np.diff(rings, axis=0), axis=1).sum()


def _set_up(ui, along=36, twist=False):
    rest, faces = bent_limb.limb(along=along)
    obj = meshes.make_object(rest.tolist(), faces, "Limb")
    shapes = {"Bend": bent_limb.bent(rest, 140.0)}
    if twist:
        shapes["Twist"] = bent_limb.twisted(rest, 120.0)
    for name, shape in shapes.items():
        steps.add_key(obj, name, shape)
    ui.remember()
    yield from _show_shape_keys(ui)
    yield from ui.key('NUMPAD_1')
    ui.frame_all()


def _show_shape_keys(ui):
    """Object Data Properties, as high as the window, so that pictures show the panel below the list of keys."""
    areas = {area.type: area for area in view.window().screen.areas}
    with bpy.context.temp_override(window=view.window(), area=areas['OUTLINER']):
        bpy.ops.screen.area_close()
    view.redraw()
    yield from ui.pause(0.2)  # it finds out that there is a mesh as it is drawn
    next(area for area in view.window().screen.areas if area.type == 'PROPERTIES').spaces.active.context = 'DATA'
    yield


def _drag(ui, value):
    """As an artist sets a slider, one undo step."""
    keys()["Bend"].value = value
    ui.remember()
    yield from ui.wait_until(settled, f"the mix is shown at {value}")


def sliders_turn_and_are_baked(ui):
    yield from _set_up(ui)
    whole = _length()
    keys()["Bend"].value = 0.5
    ui.remember()
    yield from ui.pause(0.1)
    assert _length() < 0.9 * whole
    yield from ui.screenshot("mix_1_straight_lines")

    limb().meanvalue.mix.is_on = True
    ui.remember()
    yield from ui.wait_until(settled, "the mix is shown")
    assert abs(_length() - whole) < 0.03 * whole
    yield from ui.screenshot("mix_2_switched_on")
    half = keys()[MIX].data[-1].co.copy()
    yield from _drag(ui, 0.8)
    yield from ui.screenshot("mix_3_dragged")
    settled_at_once = shape()
    for value in (0.1, 0.3, 0.5, 0.7):  # without rest between
        keys()["Bend"].value = value
        yield from ui.pause(0.05)
    keys()["Bend"].value = 0.8
    yield from ui.wait_until(settled, "the mix is shown at 0.8 again")
    assert np.array_equal(shape(), settled_at_once), "it depends on the sliders' values alone"
    yield from ui.undo()
    yield from ui.wait_until(settled, "the undo is shown")
    assert abs(keys()["Bend"].value - 0.5) < 1e-6
    assert (keys()[MIX].data[-1].co - half).length < 1e-3

    yield from ui.invoke("meanvalue.bake_mix")
    yield from ui.wait_until(lambda: ui.status_text() is None and MIX not in keys(), "it is baked")
    assert abs(_length() - whole) < 0.03 * whole
    assert any("driven by its sliders" in line for line in ui.reports()), ui.reports()
    yield from ui.screenshot("mix_4_baked")
    yield from ui.undo()
    yield from ui.wait_until(settled, "it is live again")
    assert limb().meanvalue.mix.is_on and [key.name for key in keys()] == ["Basis", "Bend", MIX]
    yield from ui.redo()
    assert not limb().meanvalue.mix.is_on and len(keys()) > 3
    limb().shape_key_remove(keys()["Bend"])
    yield from ui.pause(0.2)
    yield from ui.screenshot("mix_5_slider_deleted")
    yield from ui.invoke("meanvalue.bake_mix", remove=True)
    assert [key.name for key in keys()] == ["Basis"]


def esc_stops_the_bake(ui):
    yield from _set_up(ui, along=1200, twist=True)
    limb().meanvalue.mix.tolerance_share = 0.001
    before = snapshot(limb())
    yield from ui.invoke("meanvalue.bake_mix")
    yield from ui.wait_until(lambda: "solved" in (ui.status_text() or ""), "the status bar tells how many are solved")
    assert "Baking the mix of 'Limb'" in ui.status_text() and "Esc: Cancel" in ui.status_text()
    yield from ui.screenshot("mix_6_baking", amid_work=True)
    yield from ui.key('ESC')
    yield from ui.wait_until(lambda: ui.status_text() is None, "the status bar is given back")
    assert_same(before, snapshot(limb()))
    assert any("Cancelled" in line for line in ui.reports()), ui.reports()
