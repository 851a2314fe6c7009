# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies what a report of a bug should say. Nothing in it tells who the artist is, or names of the scene."""

import platform

import bpy
import numpy as np

from ...scene import subject
from ...solver import native_loader
from ...widgets.base import Reporting


class MEANVALUE_OT_copy_system_info(Reporting, bpy.types.Operator):
    """Copy versions, counts and settings to the clipboard, for reports of bugs. No names, no paths"""

    bl_label = "Copy System Info"
    bl_options = {'REGISTER'}

    def execute(self, context):
        lines = [f"{label}: {value}" for label, value in (*_versions(), *_facts(subject.of(context)))]
        text = "\n".join(lines) + "\n"
        context.window_manager.clipboard = text
        if bpy.app.background:  # which has no clipboard
            print(text)
        self.report({'INFO'}, "Copied. Paste it into the report.")
        return {'FINISHED'}


def _versions():
    package = __package__.removesuffix(".posing.operators")
    yield "Mean-Value Deform", "extension" if package.startswith("bl_ext.") else "legacy add-on"
    if native_loader.problem() is None:
        info = native_loader.module().build_info()
        yield "Solver", f"{native_loader.module().__version__}, {', '.join(f'{key} {info[key]}' for key in info)}"
    else:
        yield "Solver", "cannot be loaded"
    yield "Blender", f"{bpy.app.version_string}, Python {platform.python_version()}, numpy {np.__version__}"
    yield "System", f"{platform.platform()}, {platform.processor() or platform.machine()}"


def _facts(obj):
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
