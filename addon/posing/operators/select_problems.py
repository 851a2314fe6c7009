# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the artist what is messy about a mesh."""

import contextlib

import bpy
import numpy as np
from bpy.props import EnumProperty

from ... import wording
from ...errors import SceneError
from ...scene import kept, mesh_arrays, mirrors, selection, shape_keys
from ...solver import session
from ...widgets.base import MeshOperator
from ..bridge import scene_input
from ..core import mesh_problems

ALL = 'ALL'


class MEANVALUE_OT_select_problems(MeshOperator, bpy.types.Operator):
    """Select vertices of the mesh that are unusual, in Edit Mode. None of it stops posing"""

    bl_label = "Select Problem Vertices"

    kind: EnumProperty(
        name="Kind",
        description="What to select",
        items=(
            (ALL, "All", "Whatever is unusual"),
            *mesh_problems.KINDS,
        ),
        default=ALL,
    )

    def run(self, obj):
        found, distance = problems(obj)
        chosen = {kind: vertices for kind, vertices in found.items() if self.kind in {ALL, kind}}
        if not chosen:
            return f"Nothing {'unusual' if self.kind == ALL else 'of that kind'} was found on '{obj.name}'", []
        vertices = np.unique(np.concatenate(list(chosen.values())))
        selection.choose(obj)
        notes = selection.edit_with_selected(obj, vertices)
        names = {kind: name for kind, name, _about in mesh_problems.KINDS}
        names['GAP'] += f", closed by Merge Distance {distance:g}"
        counts = wording.listed(f"{names[kind]} ({len(each):,})" for kind, each in chosen.items())
        return f"{wording.vertices(len(vertices))} selected: {counts}", notes


def problems(obj):
    """As mesh_problems.find(); with what only a binding knows where there is one that fits the scene."""
    rest = shape_keys.rest_positions(obj.data)
    triangles = mesh_arrays.triangles(obj.data, rest)
    report = places = None
    with contextlib.suppress(SceneError):  # no handles yet, say: the mesh can be looked at all the same
        bind_input = scene_input.gather(obj)
        places, binding = bind_input.solver_mesh.places, session.cached(bind_input)
        report = binding.deformer.report if binding is not None else None
    return mesh_problems.find(rest, triangles, report, places, mirrors.partners(obj, rest), kept.copies(obj, rest))
