# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the panel as the guide shows them. `./dev docs pictures` takes these and others into docs/pictures.

./dev test --only ui -k guide_pictures
"""

from harness import tabs
from support import handles, meshes


def bake(ui):
    obj, control = handles.tube()
    control.keyframe_insert("location", frame=1)
    meshes.activate(obj)
    ui.frame_all()
    yield from tabs.open_part(ui, "baking")
    yield from tabs.scroll_down(ui)
    yield from ui.screenshot("guide_bake")


def values(ui):
    obj = meshes.grid(9, 9)
    for name in ("Basis", "Smile", "Frown"):
        obj.shape_key_add(name=name, from_mix=False)
    for point in (40, 41):
        obj.data.shape_keys.key_blocks["Smile"].data[point].co.z += 1.0
        obj.data.shape_keys.key_blocks["Frown"].data[point].co.z -= 1.0
    obj.meanvalue.drive = 'SHAPE_KEYS'
    meshes.activate(obj)
    ui.frame_all()
    yield from tabs.open_part(ui, "sliders")
    yield from ui.screenshot("guide_values")
