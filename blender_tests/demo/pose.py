# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing by the add-on's operators, as an artist's clicks would, and the figures for the report."""

import importlib
import time
from dataclasses import dataclass

import bpy
import numpy as np
from support import installed, meshes, steps

from .errors import DemoError

ADDON = installed.PACKAGE


@dataclass(frozen=True)
class PoseFigures:
    """What the report says of one pose. Energies are G of eq 15 at bounding-box diagonal 1; times in seconds."""

    vertex_count: int
    face_count: int
    free_count: int
    anchor_count: int
    guarded_count: int
    energy_before: float
    energy_after: float
    bind_seconds: float
    solve_seconds: float


def install_addon(zip_path):
    """Installs and enables the add-on's zip in this Blender's user folder. @throws DemoError."""
    if not zip_path:
        raise DemoError("MEANVALUE_ADDON_ZIP does not say where the add-on's zip is; start this by ./dev demo")
    bpy.ops.preferences.addon_install(filepath=str(zip_path), overwrite=True)
    bpy.ops.preferences.addon_enable(module=ADDON)
    if not hasattr(bpy.types.Object, "meanvalue"):
        raise DemoError(f"{zip_path} was installed, but the add-on {ADDON} did not start; see the messages above")


def positions(obj, key=None):
    """(n, 3) float64 of a shape key, or of the rest shape."""
    keys = obj.data.shape_keys
    if key is None and keys is not None:
        key = keys.reference_key
    source = obj.data.vertices if key is None else key.data
    values = np.empty(3 * len(source), dtype=np.float32)
    source.foreach_get("co", values)
    return values.reshape(-1, 3).astype(np.float64)


def seen_in_world(obj):
    """(n, 3) world positions, modifiers included."""
    matrix = np.array(obj.matrix_world, np.float32)
    return meshes.seen(obj) @ matrix[:3, :3].T + matrix[:3, 3]


def pose_by_operators(subject):
    """Adds the anchor groups, binds, puts the anchors on their targets and solves; returns PoseFigures.

    The result is in the shape key `obj.meanvalue.result_key`. @throws DemoError with the add-on's own words.
    """
    obj = subject.obj
    bpy.context.view_layer.objects.active = obj
    if subject.grab is not None:
        return grabbed(subject)
    obj.meanvalue.handles.clear()
    for name in subject.handles:
        call(bpy.ops.meanvalue.add_handle, pin=True, group=name)
    obj.meanvalue.roi_group = subject.roi_group

    start = time.perf_counter()
    call(bpy.ops.meanvalue.bind)
    bind_seconds = time.perf_counter() - start

    if subject.targets is not None:
        write_pose_key(obj, subject)
    posed = positions(obj, obj.active_shape_key)
    start = time.perf_counter()
    call(bpy.ops.meanvalue.solve_from_key)
    solve_seconds = time.perf_counter() - start
    return figures(obj, posed, bind_seconds, solve_seconds)


def grabbed(subject):
    """PoseFigures of the mesh as one press and drag poses it."""
    vertex, offset, size = subject.grab
    start = time.perf_counter()
    call(bpy.ops.meanvalue.grab, vertex=vertex, offset=offset, size=size)
    bpy.context.view_layer.update()
    seconds = time.perf_counter() - start
    subject.obj.meanvalue.live = False  # while it is photographed
    bpy.context.view_layer.objects.active = subject.obj
    posed = positions(subject.obj, result_key(subject.obj))
    return figures(subject.obj, posed, 0.0, seconds)


def call(operator, **options):
    """Runs an operator; its error report, which Blender raises, becomes a DemoError."""
    try:
        result = operator(**options)
    except RuntimeError as error:
        raise DemoError(operator_message(error)) from error
    if result != {"FINISHED"}:
        raise DemoError(f"{operator.idname_py()} ended with {', '.join(result)}")


def operator_message(error):
    """What an operator reported, out of the RuntimeError that Blender makes of it."""
    return str(error).strip().removeprefix("Error: ")


def write_pose_key(obj, subject):
    """A new shape key with the anchors on their targets, as moving them in Edit Mode would leave it."""
    anchors = anchor_indices(obj, subject.handles)
    pose = positions(obj)
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name="Pose", from_mix=False)
    obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(key.name)
    pose[anchors] = subject.targets[anchors]
    obj.active_shape_key.data.foreach_set("co", pose.astype(np.float32).ravel())
    obj.data.update_tag()


def held(obj):
    """Ascending indices of the vertices of all handles."""
    return np.unique(np.concatenate([steps.held(obj, handle.name) for handle in obj.meanvalue.handles])).astype(int)


def anchor_indices(obj, group_names):
    """Ascending indices of the vertices of weight above 0 in any of the vertex groups."""
    return np.unique(np.concatenate([group_indices(obj, name) for name in group_names]))


def group_indices(obj, name):
    """Ascending indices of the vertices of weight above 0 in one vertex group."""
    group = obj.vertex_groups[name].index
    members = [
        vertex.index
        for vertex in obj.data.vertices
        if any(element.group == group and element.weight > 0.0 for element in vertex.groups)
    ]
    return np.array(members, dtype=int)


def figures(obj, posed, bind_seconds, solve_seconds):
    """PoseFigures from what it is bound as, and G of the result and of where the solver starts: the rest shape with
    the anchors where `posed` (n, 3) has them."""
    bound = steps.summary(obj)
    rest, anchors = positions(obj), held(obj)
    teleported = rest.copy()
    teleported[anchors] = posed[anchors]
    encoding = whole_encoding(obj, rest)
    diagonal = np.linalg.norm(rest.max(axis=0) - rest.min(axis=0))
    return PoseFigures(
        vertex_count=len(obj.data.vertices),
        face_count=len(obj.data.polygons),
        free_count=bound.free_count,
        anchor_count=bound.anchor_count,
        guarded_count=len(encoding.guarded),
        energy_before=encoding.energy(teleported) / diagonal**2,
        energy_after=encoding.energy(positions(obj, result_key(obj))) / diagonal**2,
        bind_seconds=bind_seconds,
        solve_seconds=solve_seconds,
    )


def whole_encoding(obj, rest):
    """The native encoding of the whole rest mesh `rest` (n, 3)."""
    native = importlib.import_module(f"{ADDON}.solver.native_loader").module()
    obj.data.calc_loop_triangles()
    triangles = np.empty(3 * len(obj.data.loop_triangles), dtype=np.int32)
    obj.data.loop_triangles.foreach_get("vertices", triangles)
    return native.encode(rest, triangles.reshape(-1, 3))


def result_key(obj):
    """The shape key that the add-on wrote."""
    return obj.data.shape_keys.key_blocks[obj.meanvalue.result_key]
