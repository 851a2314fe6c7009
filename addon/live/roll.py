# SPDX-License-Identifier: GPL-3.0-or-later
"""Who is live: the follower of each object, of the kinds that rooms bring (see live/following.py).

Nothing of Blender's is held: objects are known by what tells them apart while the file is open, and looked up by name.
"""

import bpy

from .. import compat
from ..rooms import ALL
from ..scene import subject

_followers = {}  # identity of the object: its follower
_are_waited_for = False  # objects that ask to follow and cannot yet, as linked ones until they are made local


def kinds_on(obj):
    """The kinds of followers that are turned on for `obj`."""
    return [kind for kind in ALL.followers if kind.asks_for(obj)]


def turned_on(obj, kind):
    """A kind of follower was turned on for `obj`: of all that shapes a mesh at once, it alone is."""
    for other in kinds_on(obj):
        if other is not kind:
            other.turn(obj, False)
    note(obj)


def identity(obj):
    """Tells an object with its mesh apart from all others while the file is open, whatever they are called."""
    return compat.session_key(obj), compat.session_key(obj.data) if obj.data else None


def known():
    """[(identity, object, follower)] of all that were live when it was looked last, and are there. On any thread."""
    found = [(key, bpy.data.objects.get(follower.name), follower) for key, follower in list(_followers.items())]
    return [each for each in found if each[1] is not None and identity(each[1]) == each[0]]


def note(obj):
    """Takes an object in that was turned live."""
    kind = _kind(obj)
    if kind is not None and follower_of(obj) is None:
        _followers[identity(obj)] = kind(obj)


def has_any():
    return _are_waited_for or bool(_followers)


def forget():
    for follower in _followers.values():
        follower.stop()
    _followers.clear()


def follower_of(obj):
    """The follower of a live object, or None."""
    return _followers.get(identity(obj))


def _kind(obj):
    """The class of the follower that `obj` asks for, or None."""
    asked_for = next(iter(kinds_on(obj)), None) if obj.type == 'MESH' else None
    return None if asked_for is None or subject.object_problem(obj) is not None else asked_for


def search():
    """Finds the live objects, whatever they are called by now; keeps what is known of them."""
    global _are_waited_for
    known, _are_waited_for = dict(_followers), False
    _followers.clear()
    for obj in bpy.data.objects:
        kind = _kind(obj)
        _are_waited_for |= kind is None and obj.type == 'MESH' and bool(kinds_on(obj))
        if kind is not None:
            follower = known.get(identity(obj))
            if type(follower) is kind:
                known.pop(identity(obj))
            else:
                follower = kind(obj)
            follower.name = obj.name
            _followers[identity(obj)] = follower
    for follower in known.values():
        follower.stop()


def live_objects():
    """(object, follower) of all that are live."""
    found = known()
    if len(found) < len(_followers) or any(_kind(obj) is not type(follower) for _, obj, follower in found):
        search()
        found = known()
    return [(obj, follower) for _, obj, follower in found]


def gives_way_to(other_name):
    """Why an object does not follow, in words, where another with the same mesh does."""
    return f"'{other_name}' has the same mesh and is live. Turn that off, or make the mesh a single user"


def in_charge():
    """(object, follower) of those that may write; of several with the same mesh all others give way."""
    writers = {}  # mesh: name of the object that writes its shape key
    for obj, follower in live_objects():
        writer = writers.setdefault(obj.data.name, obj.name)
        if writer == obj.name:
            yield obj, follower
        else:
            follower.give_up(gives_way_to(writer))
