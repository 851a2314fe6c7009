# SPDX-License-Identifier: GPL-3.0-or-later
"""The pose becomes the rest shape."""

from .. import compat, wording
from ..rooms import ALL
from . import pose_key, shape_keys, surface_hair


def become(obj):
    """The result becomes the reference key. Keys that add to that move along by as much, so that they add the same.

    Returns notes, as sentences. @throws SceneError if there is no result.
    """
    shape = shape_keys.pose_to_use(obj)
    mesh = obj.data
    reference = mesh.shape_keys.reference_key
    offset = shape - shape_keys.positions(reference)
    surface_hair.follow(obj, shape - offset, shape)
    apart = {reference, shape_keys.result(obj), *pose_key.replacing(obj)}
    carried = []
    for key in mesh.shape_keys.key_blocks:
        if _adds_to(key, reference, apart):
            shape_keys.write_positions(mesh, key, shape_keys.positions(key) + offset)
            carried.append(key.name)
    shape_keys.write_positions(mesh, reference, shape)
    store, attribute = compat.position_store(mesh)
    store.foreach_set(attribute, shape.ravel())
    mesh.update()
    return list(_notes(obj, carried))


def _notes(obj, carried):
    for made, note in (names_and_note(obj) for names_and_note in ALL.made_of_rest):
        if note:
            yield note
        carried = [name for name in carried if name not in made]
    if carried:
        keys = wording.counted(len(carried), "shape key")
        yield f"{keys} carried along by what they add, and may look different: {wording.quoted(carried)}"


def _adds_to(key, reference, apart):
    """Whether a key is relative to the reference key, by way of others or not, but not by way of those `apart`."""
    passed = set()
    while key.name not in passed and key not in apart:
        passed.add(key.name)
        key = key.relative_key
    return key == reference and bool(passed)
