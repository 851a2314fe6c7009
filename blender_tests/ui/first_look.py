# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender starts with the add-on, and its tab in the sidebar opens."""

from support import meshes

TAB = "Mean-Value"


def open_the_tab(ui):
    meshes.tube()
    ui.frame_all()
    yield from ui.open_tab(TAB)
    yield from ui.screenshot("first_look")
