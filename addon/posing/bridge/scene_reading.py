# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads what takes long of an object, bit by bit, so that nobody has to wait for a big mesh."""

import math
import time

from ... import compat
from ...scene import declarations, mesh_arrays, mirrors, vertex_groups
from . import controls


class SceneReading:
    """The members of the groups that the settings name, and the faces. `members` and `faces` are None until read.

    Nothing of Blender's is kept: the object is handed in for each part. What was read is worth nothing once the object
    was edited.

    members  {name: ascending vertex indices, int32} of the listed groups and the region, those that exist
    region_weights  n float64, 0 to 1, of the region; None if there is none
    faces    (corners, starts) as of mesh_arrays.faces()
    """

    def __init__(self, obj):
        self.members = self.region_weights = self.faces = None
        self._mesh, self._names = _mesh_facts(obj), _names(obj)
        self._groups = vertex_groups.Reading(obj, self._names)

    def go_on(self, obj, seconds=math.inf):
        """Reads for about so long, something in any case. Returns whether all is read."""
        until = time.monotonic() + seconds
        if self.members is None:
            if not self._groups.go_on(obj, seconds):
                return False
            self.members = self._groups.members
            self.region_weights = self._groups.weights.get(obj.meanvalue.roi_group)
            self._groups = None
            if time.monotonic() >= until:
                return False
        if self.faces is None:
            self.faces = mesh_arrays.faces(obj.data)
        return True

    @property
    def share(self):
        """How much is read, 0 to 1."""
        return 1.0 if self._groups is None else self._groups.share

    def fits(self, obj):
        """Whether it is of this object as it is now, as far as that is quick to tell."""
        return self._mesh == _mesh_facts(obj) and self._names == _names(obj)


def signature(obj):
    """All that is quick to compare of what a binding depends on. Blender does not tell of each of these changes."""
    deleted = tuple(handle.name for handle in obj.meanvalue.handles if controls.is_deleted(handle))
    return _mesh_facts(obj), declarations.values(obj.meanvalue), deleted


def _names(obj):
    return {handle.name for handle in obj.meanvalue.handles} | {obj.meanvalue.roi_group}


def _mesh_facts(obj):
    mesh = obj.data
    counts = len(mesh.vertices), len(mesh.polygons)
    return obj.name, compat.session_key(mesh), counts, tuple(obj.vertex_groups.keys()), mirrors.signature(obj)
