# SPDX-License-Identifier: GPL-3.0-or-later
"""What has to be told of renders: nothing follows while one runs, so animated controls and sliders have no effect.

Frames are rendered on a thread of their own, where handlers may look and not write. They note here what they see; it is
told by the console at once, and by a popup and the panel as soon as Blender calls a timer.
"""

from .. import wording
from ..scene import views

_at_first = {}  # identity of an object: the first frame
_notes = {}  # identity of an object: what is to be told, and whether only until it is solved
untold = []  # notes that no popup has shown

#: What the panel says beforehand, of what and with what else to mind.
WHILE_ANIMATED = "The {} are animated, but animations that you render or export show one pose. Press Bake before{}"


def begin(unsettled):
    """A render begins. unsettled: [(identity, name)] of objects whose mesh does not show the settled answer yet."""
    forget()
    for identity, name in unsettled:
        _tell(identity, f"'{name}' was still being solved when the render began. Wait for it, and render again", True)


def look(identity, obj, follower, frame):
    """A frame is about to be rendered."""
    is_first = _at_first.setdefault(identity, frame) == frame
    if is_first or identity in _notes or obj.meanvalue.baked.target or not follower.is_animated(obj):
        return
    moving = f"The {follower.FOLLOWS} of '{obj.name}' are animated"
    _tell(identity, f"{moving}, but renders show one pose. Bake, and render again")


def of(identity, is_behind):
    """What the panel has to tell of an object since the last render, or None."""
    note, is_over_when_solved = _notes.get(identity, (None, False))
    return note if is_behind or not is_over_when_solved else None


def forget():
    for known in (_at_first, _notes, untold):
        known.clear()


def _tell(identity, note, is_over_when_solved=False):
    _notes[identity] = note, is_over_when_solved
    untold.append(note)
    views.say(wording.sentence(note))
