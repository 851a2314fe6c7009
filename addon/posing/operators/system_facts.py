# SPDX-License-Identifier: GPL-3.0-or-later
"""What Copy System Info tells, as posing/core/system_info.py writes it."""

import contextlib
import getpass
import os
import pathlib
import platform
import sys

import bpy
import numpy as np

from ... import ids, wording
from ...live import engine
from ...scene import declarations, subject
from ...solver import native_loader
from ...widgets.core import last_message
from ..bridge import bound_record, object_status, region
from ..core import system_info

PACKAGE = __package__.removesuffix(".posing.operators")


def sections(obj):
    """((heading, ((label, value), ...)), ...) of this Blender and of the object that is worked on, or None for none."""
    private = _private_words()
    found = [("", _versions(private)), ("Said", _said(obj, private))]
    if obj is None:
        found.insert(1, ("Active object", (("Type", "none"),)))
    elif subject.object_problem(obj) is not None:
        found.insert(1, ("Active object", (("Type", obj.type), ("Linked or overridden", obj.type == 'MESH'))))
    else:
        found[1:1] = [("Active object", _counts(obj)), ("Settings", _settings(obj.meanvalue))]
    return found


def _versions(private):
    version = getattr(sys.modules[PACKAGE], "bl_info", {}).get("version", ())
    kind = "extension" if PACKAGE.startswith("bl_ext.") else "legacy add-on"
    return (
        ("Mean-Value Deform", f"{'.'.join(map(str, version)) or 'unknown'}, {kind}"),
        ("Solver", _solver(private)),
        ("Blender", f"{bpy.app.version_string}{', in the background' if bpy.app.background else ''}"),
        ("Python", f"{platform.python_version()}, numpy {np.__version__}"),
        ("System", platform.platform()),
        ("Processor", f"{system_info.processor()}, {wording.counted(os.cpu_count() or 1, 'thread')}"),
    )


def _solver(private):
    problem = native_loader.problem()
    if problem:
        return system_info.without_names(problem, private)
    module = native_loader.module()
    info = module.build_info()
    threads = wording.counted(info["threads"], "thread")
    return f"{module.__version__}, {info['compiler']}, Eigen {info['eigen']}, {info['instructions']}, {threads}"


def _counts(obj):
    mesh = obj.data
    keys = mesh.shape_keys
    handles = obj.meanvalue.handles
    off = sum(not handle.is_enabled for handle in handles)
    soft = sum(handle.is_soft for handle in handles)
    return (
        ("Vertices", f"{len(mesh.vertices):,}"),
        ("Edges", f"{len(mesh.edges):,}"),
        ("Faces", f"{len(mesh.polygons):,}"),
        ("Mode", obj.mode),
        ("Scale", ", ".join(f"{part:g}" for part in obj.scale)),
        ("Modifiers", system_info.counted(modifier.type for modifier in obj.modifiers)),
        ("Shape keys", len(keys.key_blocks) if keys else 0),
        ("Absolute shape keys", keys is not None and not keys.use_relative),
        ("Handles", system_info.counted(handle.follows for handle in handles if handle.follows != 'REST')),
        ("Pins", sum(handle.follows == 'REST' for handle in handles)),
        ("Handles and pins that are off, soft", f"{off}, {soft}"),
        ("Region", _region(obj)),
        ("Objects with the mesh", mesh.users),
    )


def _region(obj):
    if not obj.meanvalue.roi_group:
        return "the whole mesh"
    if obj.mode == 'EDIT':
        return "not read in Edit Mode"
    weights = region.weights(obj)
    between = int(((weights > 0.0) & (weights < 1.0)).sum())
    inverted = ", inverted" if obj.meanvalue.roi_invert else ""
    return f"{wording.vertices(int((weights > 0.0).sum()))}, {between:,} of them with a falloff{inverted}"


def _settings(settings):
    return (
        *_declared_settings(settings),
        ("Live", settings.live),
        ("Baked", settings.baked.target or "no"),
        *_room_settings(settings),
    )


def _room_settings(settings):
    """What is set of the groups that other rooms keep, but for names."""
    for pointer in settings.bl_rna.properties:
        if pointer.type != 'POINTER' or pointer.identifier in {"bound", "baked", "rna_type"}:
            continue
        group = getattr(settings, pointer.identifier)
        for setting in group.bl_rna.properties:
            value = getattr(group, setting.identifier)
            if setting.type == 'COLLECTION' and len(value):
                yield f"{pointer.identifier}, {setting.name or setting.identifier}", len(value)
            elif setting.type in {'BOOLEAN', 'INT', 'ENUM'} and group.is_property_set(setting.identifier):
                yield f"{pointer.identifier}, {setting.name or setting.identifier}", value


def _declared_settings(settings):
    """All that a binding depends on but for names that the artist gave, and the lists."""
    for name in declarations.names(type(settings)):
        value, setting = getattr(settings, name), settings.bl_rna.properties[name]
        if setting.type == 'FLOAT':
            yield setting.name, f"{value:g}"
        elif setting.type in {'BOOLEAN', 'INT', 'ENUM'}:
            yield setting.name, value


def _said(obj, private):
    """What the add-on says of the object, and said last."""
    told = []
    if obj is not None and subject.object_problem(obj) is None:
        bound = obj.meanvalue.bound
        solved = bound_record.read_solve(bound)
        live = engine.status(obj)
        told = [
            ("Status", object_status.status(obj).text),
            ("Bound", _bind_report(bound) if bound.is_bound else "no"),
            ("Solved", solved.text() if solved else "no"),
            ("Live", live[0] if live else None),
        ]
    told.append(("Last message", last_message.last()))
    return tuple((label, text and system_info.without_names(text, private)) for label, text in told)


def _bind_report(bound):
    summary = bound_record.read_summary(bound)
    return ". ".join([summary.text(), *summary.notes()])


def _private_words():
    """Names that the artist gave, where they may stand without quotes, and where the files are."""
    file = pathlib.Path(bpy.data.filepath)
    words = {str(file), *file.parts, file.stem, bpy.app.tempdir, str(pathlib.Path.home()), platform.node()}
    with contextlib.suppress(KeyError, OSError):  # a user without a name
        words.add(getpass.getuser())
    for blocks in (bpy.data.objects, bpy.data.meshes, bpy.data.collections, bpy.data.scenes, bpy.data.actions):
        words.update(block.name for block in blocks)
    for obj in bpy.data.objects:
        words.update(group.name for group in obj.vertex_groups)
    return words - {value for value in vars(ids).values() if isinstance(value, str)}
