# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a mesh is still the one that was bound, told from its content alone: a binding is remembered in the .blend as
a fingerprint of all that it depends on, which follows undo, duplication, renaming and reopening."""

import hashlib
from typing import NamedTuple

import numpy as np

from ... import wording

#: What the digests of the mesh tell, in words: the anchors may no longer mean the same vertices.
CHANGES = {"faces": "the faces were changed", "rest_shape": "the rest shape was edited"}


class Fingerprint(NamedTuple):
    """The count of vertices, for messages, and digests of what a binding depends on."""

    vertex_count: int
    faces: str
    rest_shape: str
    kept: str  # what stays as it is where other anchors are bound
    anchors: str

    @property
    def family(self):
        """What bindings have in common that may be made from each other."""
        return self[:4]


def digest(*parts):
    """Hex digest of numpy arrays, texts and None, their types and shapes included. About 1 ms per megabyte."""
    state = hashlib.blake2b(digest_size=16)
    for part in parts:
        if part is None or isinstance(part, str):
            state.update(str(part).encode())
            continue
        array = np.ascontiguousarray(part)
        state.update(f"{array.dtype.str}{array.shape}".encode())
        state.update(array)
    return state.hexdigest()


def changes(bound, now):
    """Why the artist must look and press Update, in words, or "": after other changes what poses the mesh next binds
    again by itself. bound: a Fingerprint, or the record of one."""
    if bound.vertex_count != now.vertex_count:  # then all else differs too, which would say nothing new
        return f"the mesh has {wording.vertices(now.vertex_count)} ({bound.vertex_count:,} when bound)"
    return wording.listed(words for name, words in CHANGES.items() if getattr(bound, name) != getattr(now, name))
