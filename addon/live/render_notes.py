# SPDX-License-Identifier: GPL-3.0-or-later
"""What has to be told of renders: nothing follows while one runs, so animated controls and sliders have no effect.

Handlers on the thread that renders may look and not write. What they see is told by the console at once, and by a popup
as soon as Blender calls a timer.
"""

from .. import wording
from ..scene import views

_at_first = {}  # identity of an object: the first frame that was rendered
_told = set()  # identities of objects
untold = []  # notes that no popup has shown

#: What the panel says beforehand of what is animated, and with what else to mind.
WHILE_ANIMATED = "Renders and exports show one pose. Bake first{}"


def begin(unsettled):
    """A render begins. unsettled: names of objects whose mesh does not show the settled answer yet."""
    forget()
    for name in unsettled:
        _tell(f"'{name}' was still being solved when the render began. Wait for it, and render again")


def look(identity, obj, follower, frame):
    """A frame is about to be rendered."""
    is_first = _at_first.setdefault(identity, frame) == frame
    if is_first or identity in _told or obj.meanvalue.baked.target or not follower.is_animated(obj):
        return
    _told.add(identity)
    _tell(f"The {follower.FOLLOWS} of '{obj.name}' are animated, but renders show one pose. Bake, and render again")


def forget():
    for known in (_at_first, _told, untold):
        known.clear()


def _tell(note):
    untold.append(note)
    views.say(wording.sentence(note))
