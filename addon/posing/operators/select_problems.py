# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows the artist what is messy about a mesh, and copies what a report of a bug should say. Nothing in that tells who
the artist is, or names of the scene."""

import contextlib
import platform

import bpy
import numpy as np
from bpy.props import EnumProperty

from ... import wording
from ...errors import SceneError
from ...scene import kept, mesh_arrays, mirrors, shape_keys, subject
from ...solver import native_loader, session
from ...widgets.base import MeshOperator, Reporting
from ..bridge import scene_input
from ..core import mesh_problems

ALL = 'ALL'


class MEANVALUE_OT_select_problems(MeshOperator, bpy.types.Operator):
    """Select vertices of the mesh that are unusual, in Edit Mode. None of it stops posing"""

    bl_label = "Select Problem Vertices"

    kind: EnumProperty(
        name="Kind",
        description="What to select",
        items=((ALL, "All", "Whatever is unusual"), *mesh_problems.KINDS),
        default=ALL,
    )

    def run(self, obj):
        found, distance = problems(obj)
        chosen = {kind: vertices for kind, vertices in found.items() if self.kind in {ALL, kind}}
        if not chosen:
            return f"Nothing {'unusual' if self.kind == ALL else 'of that kind'} was found on '{obj.name}'", []
        vertices = np.unique(np.concatenate(list(chosen.values())))
        subject.choose(obj)
        notes = subject.edit_with_selected(obj, vertices)
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
        places, binding = bind_input.solver_mesh.places, session.cache.get(bind_input.fingerprint)
        report = binding.deformer.report if binding is not None else None
    return mesh_problems.find(rest, triangles, report, places, mirrors.partners(obj, rest), kept.copies(obj, rest))


class MEANVALUE_OT_copy_system_info(Reporting, bpy.types.Operator):
    """Copy versions, counts and settings to the clipboard, for reports of bugs. No names, no paths"""

    bl_label = "Copy System Info"
    bl_options = {'REGISTER'}

    def execute(self, context):
        lines = [f"{label}: {value}" for label, value in _facts(subject.of(context))]
        text = "\n".join(lines) + "\n"
        context.window_manager.clipboard = text
        if bpy.app.background:  # which has no clipboard
            print(text)
        self.report({'INFO'}, "Copied. Paste it into the report.")
        return {'FINISHED'}


def _facts(obj):
    package = __package__.removesuffix(".posing.operators")
    yield "Mean-Value Deform", "extension" if package.startswith("bl_ext.") else "legacy add-on"
    if native_loader.problem() is None:
        info = native_loader.module().build_info()
        yield "Solver", f"{native_loader.module().__version__}, {', '.join(f'{key} {info[key]}' for key in info)}"
    else:
        yield "Solver", "cannot be loaded"
    yield "Blender", f"{bpy.app.version_string}, Python {platform.python_version()}, numpy {np.__version__}"
    yield "System", f"{platform.platform()}, {platform.processor() or platform.machine()}"
    problem = subject.object_problem(obj)
    yield "Active object", f"{obj.type if obj else 'none'}{' that cannot be posed' if problem else ''}"
    if problem:
        return
    mesh, settings = obj.data, obj.meanvalue
    yield "Vertices, edges, faces", f"{len(mesh.vertices):,}, {len(mesh.edges):,}, {len(mesh.polygons):,}"
    yield "Mode", obj.mode
    yield "Scale", ", ".join(f"{part:g}" for part in obj.scale)
    yield "Modifiers", ", ".join(modifier.type for modifier in obj.modifiers)
    yield "Handles and pins, region", f"{len(settings.handles)}, {bool(settings.roi_group)}"
    yield "Live, bound, baked", f"{settings.live}, {settings.bound.is_bound}, {settings.baked.target or False}"
    for name in type(settings).__annotations__:
        setting = settings.bl_rna.properties[name]
        if setting.type in {'BOOLEAN', 'INT', 'ENUM', 'FLOAT'}:  # names and lists are the artist's
            yield setting.name, getattr(settings, name)
