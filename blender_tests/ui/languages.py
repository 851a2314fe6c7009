# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in other languages: words fit, and the pictures are for looking at.

    ./dev test --only ui -k languages
"""

import bpy
from support import installed, meshes, steps

SEGMENTS = 24


def german_panel(ui):
    yield from _pictures(ui, "de_DE", "Gebunden: ")


def french_panel(ui):
    yield from _pictures(ui, "fr_FR", "Lié : ")


def japanese_panel(ui):
    yield from _pictures(ui, "ja_JP", "バインド済み: ")


def chinese_panel(ui):
    codes = set(bpy.app.translations.locales)
    yield from _pictures(ui, "zh_HANS" if "zh_HANS" in codes else "zh_CN", "已绑定: ")


def _pictures(ui, language, bound):
    settings = bpy.context.preferences.view
    settings.language = language
    settings.use_translate_interface = True
    try:
        tube = meshes.tube(rings=25, segments=SEGMENTS)
        ui.frame_all()
        yield from ui.open_tab("Mean-Value")
        yield from ui.screenshot(f"language_{language}_1_no_handles")
        steps.list_anchors(tube, Bottom=range(SEGMENTS), Top=range(24 * SEGMENTS, 25 * SEGMENTS))
        assert bpy.ops.meanvalue.bind('EXEC_DEFAULT', True) == {'FINISHED'}
        object_model = installed.part("bridge.object_model")
        yield
        yield from ui.wait_until(lambda: object_model.quiet_in() <= 0.0, "the mesh was left alone")
        for _ in range(20):  # panels slide to their new places
            yield
        yield from ui.screenshot(f"language_{language}_2_bound")
        status = installed.part("bridge.object_status").status(tube)
        assert status.text.startswith(bound), status.text
    finally:
        settings.language = "en_US"
