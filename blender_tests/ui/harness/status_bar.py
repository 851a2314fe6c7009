# SPDX-License-Identifier: GPL-3.0-or-later
"""Remembers what Python puts into the status bar, which Blender does not tell."""

import bpy

_last = None


def text():
    return _last


def watch():
    original = bpy.types.WorkSpace.status_text_set

    def status_text_set(self, text):
        global _last
        _last = text
        original(self, text)

    bpy.types.WorkSpace.status_text_set = status_text_set


def forget():
    global _last
    _last = None
