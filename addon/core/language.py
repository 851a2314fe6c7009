# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages in the language of Blender's interface, also of parts that know nothing of Blender."""

_look_up = str


def use(look_up):
    """look_up(English) gives the translation, or what it was given. `str` for English."""
    global _look_up
    _look_up = look_up


def translated(message, **values):
    """`message` in the artist's language, its places {like_this} filled.

    A test compares the messages that are written out in calls of this with the files in translations/.
    """
    text = _look_up(message)
    return text.format(**values) if values else text
