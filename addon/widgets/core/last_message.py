# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on's operators told last, for reports of bugs: Blender gives add-ons no way to read it back."""

_last = ""


def remember(text):
    global _last
    _last = text


def last():
    """ "" if nothing was told yet."""
    return _last
