# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference key (the Basis): made where a mesh has no keys, and taken away again only if the add-on made it."""

from .. import ids

#: On the datablock of a mesh's keys: without it the Basis is the artist's, to be kept.
MADE = "meanvalue_made"


def make(obj):
    """The rest shape as the first key of a mesh without any."""
    obj.shape_key_add(name=ids.BASIS_KEY, from_mix=False)
    obj.data.shape_keys[MADE] = True


def remove_lone(obj):
    """Takes the last key away, if it is the Basis and the add-on made it."""
    keys = obj.data.shape_keys
    if keys is not None and len(keys.key_blocks) == 1 and keys.get(MADE):
        obj.shape_key_clear()
