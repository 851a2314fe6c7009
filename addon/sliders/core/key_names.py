# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of shapes and of shape keys: which mean the same."""

import functools
import re

from ... import wording
from ...errors import SceneError

SIDES = {"left": "l", "right": "r"}


@functools.lru_cache(4096)
def folded(name):
    """What is left without case and separators, sides as letters: jawOpen, Jaw_Open; EyeBlinkLeft, eyeBlink_L."""
    plain = "".join(letter for letter in name.lower() if letter.isalnum())
    side = next((side for side in SIDES if plain.endswith(side) and plain != side), None)
    return plain if side is None else plain.removesuffix(side) + SIDES[side]


def matched(names, keys, given=""):
    """{name: key} of those of `names` that `keys` has: as `given`, else the same name, else one that folds alike,
    else one that folds as the end of the name does: blendShapes.JawOpen, morphTargetInfluences[jawOpen].

    given: "name=key; name=key; ..."; nothing behind = leaves a name out. No key has two names: the first counts.
    @throws SceneError for what is given and not there.
    """
    wanted = _given(given, names, keys)
    found = {name: key for name, key in wanted.items() if key}
    for simple in SIMPLER:
        alike = {}
        for key in keys:
            alike.setdefault(simple(key), key)
        for name in names:
            key = alike.get(simple(name))
            if name not in wanted and name not in found and key is not None and key not in found.values():
                found[name] = key
    return found


def _end(name):
    return folded(re.split(r"[.:|\[]", name.rstrip("]"))[-1])


def _given(text, names, keys):
    """{name: key or ""}."""
    found = {}
    for entry in filter(None, map(str.strip, text.split(";"))):
        name, equals, key = (part.strip() for part in entry.partition("="))
        if not equals:
            raise SceneError(f"'{entry}' is no pair of names. Write name=key, and a semicolon between pairs")
        of_file, of_mesh = _named(name, names), _named(key, keys)
        if of_file is None:
            raise SceneError(f"The file has no values of '{name}'. It has {wording.quoted(names, limit=12)}")
        if key and of_mesh is None:
            raise SceneError(f"The mesh has no shape key '{key}' for '{name}'. Give the name of one that it has")
        found[of_file] = of_mesh or ""
    return found


def _named(name, names):
    """The one of `names` that means `name`, or None."""
    return next((each for simple in SIMPLER for each in names if simple(each) == simple(name)), None)


#: Names that mean the same are alike by one of these, the first before the next.
SIMPLER = (str, folded, _end)
