# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of shapes and of shape keys: which mean the same."""

from ...errors import SceneError

SIDES = {"left": "l", "right": "r"}


def folded(name):
    """What is left without case and separators, sides as letters: jawOpen, Jaw_Open; EyeBlinkLeft, eyeBlink_L."""
    plain = "".join(letter for letter in name.lower() if letter.isalnum())
    side = next((side for side in SIDES if plain.endswith(side) and plain != side), None)
    return plain if side is None else plain.removesuffix(side) + SIDES[side]


def matched(names, keys, given=""):
    """{name: key} of those of `names` that `keys` has: as `given`, else the same name, else one that folds alike.

    given: "name=key; name=key; ..."; nothing behind = leaves a name out. No key has two names: the first counts.
    @throws SceneError for what is given and not there.
    """
    wanted = _given(given, names, keys)
    alike = {}
    for key in keys:
        alike.setdefault(folded(key), key)
    free = [name for name in names if name not in wanted]
    found = {name: key for name, key in wanted.items() if key}
    for name in free:
        if name in keys and name not in found.values():
            found[name] = name
    for name in free:
        key = alike.get(folded(name))
        if name not in found and key is not None and key not in found.values():
            found[name] = key
    return found


def _given(text, names, keys):
    """{name: key or ""}."""
    found = {}
    for entry in filter(None, map(str.strip, text.split(";"))):
        name, equals, key = (part.strip() for part in entry.partition("="))
        if not equals:
            raise SceneError(f"'{entry}' is no pair of names. Write name=key, and a semicolon between pairs")
        if name not in names:
            raise SceneError(f"The file has no values of '{name}'. Names are written as in the file")
        if key and key not in keys:
            raise SceneError(f"The mesh has no shape key '{key}' for '{name}'. Give the name of one that it has")
        found[name] = key
    return found
