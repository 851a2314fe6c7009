# SPDX-License-Identifier: GPL-3.0-or-later
"""What has to be told of renders: nothing follows while one runs, so animated controls and sliders have no effect.

Frames are rendered on a thread of their own, where handlers may look and not write. They note here what they see; it is
told by the console at once, and by a popup as soon as Blender calls a timer.
"""

import numpy as np

from .. import wording
from ..scene import views

_at_first = {}  # identity of an object: where its controls and sliders were in the first frame
_told = set()  # identities of objects
untold = []  # notes that no popup has shown

#: What the panel says beforehand, of what and with what else to mind.
WHILE_ANIMATED = "The {} are animated, but animations that you render or export show one pose. Press Bake before{}"


def begin(unsettled):
    """A render begins. unsettled: [(identity, name)] of objects whose mesh does not show the settled answer yet."""
    forget()
    for identity, name in unsettled:
        _tell(
            identity,
            f"'{name}' was still being solved when the render began, which shows what was there. Wait until the panel "
            "tells of no more work, and render again",
        )


def look(identity, obj, follower, depsgraph):
    """A frame is about to be rendered of what `depsgraph` has evaluated."""
    if identity in _told or obj.meanvalue.baked.target:
        return
    now = follower.places(obj, depsgraph)
    first = _at_first.setdefault(identity, now)
    if len(first) == len(now) and np.allclose(first, now, rtol=0.0, atol=1e-6):
        return
    _tell(
        identity,
        f"The {follower.FOLLOWS} of '{obj.name}' are animated, but nothing follows them while Blender renders: every "
        "frame shows the mesh as it was when the render began. Stop the render, press Bake in Mean-Value > Bake, and "
        "render again",
    )


def forget():
    for known in (_at_first, _told, untold):
        known.clear()


def _tell(identity, note):
    _told.add(identity)
    untold.append(note)
    views.say(wording.sentence(note))
