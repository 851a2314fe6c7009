# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender starts with the add-on, and its tab in the sidebar opens."""

import bpy
from support import meshes

TAB = "Mean-Value"


def open_the_tab(ui):
    meshes.tube()
    ui.frame_all()
    yield from ui.open_tab(TAB)
    yield from ui.screenshot("first_look")


def status_bar(ui):
    assert ui.status_text() is None
    bpy.context.workspace.status_text_set("Busy")
    yield
    assert ui.status_text() == "Busy"
    bpy.context.workspace.status_text_set(None)
    assert ui.status_text() is None
