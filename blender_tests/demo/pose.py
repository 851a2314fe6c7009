# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing by the add-on's operators, as an artist's clicks would, and what it took."""

import time

import bpy
import numpy as np
from support import installed, meshes, steps

from . import DemoError

ADDON = installed.PACKAGE


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
    """Adds the anchor groups, binds, puts the anchors on their targets and solves; returns {stage: seconds}.

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
    seconds = {"bind": time.perf_counter() - start}
    write_pose_key(obj, subject)
    start = time.perf_counter()
    call(bpy.ops.meanvalue.solve_from_key)
    return seconds | {"solve": time.perf_counter() - start}


def grabbed(subject):
    """{stage: seconds}: the mesh is posed as one press and drag poses it."""
    vertex, offset, size = subject.grab
    start = time.perf_counter()
    call(bpy.ops.meanvalue.grab, vertex=vertex, offset=offset, size=size)
    bpy.context.view_layer.update()
    seconds = {"solve": time.perf_counter() - start}
    subject.obj.meanvalue.live = False  # while it is photographed
    bpy.context.view_layer.objects.active = subject.obj
    return seconds


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
    pose[anchors] = subject.targets[anchors]
    steps.add_pose_key(obj).data.foreach_set("co", pose.astype(np.float32).ravel())
    obj.data.update_tag()


def held(obj):
    """Ascending indices of the vertices of all handles."""
    return np.unique(np.concatenate([steps.held(obj, handle.name) for handle in obj.meanvalue.handles])).astype(int)


def anchor_indices(obj, group_names):
    """Ascending indices of the vertices of weight above 0 in any of the vertex groups."""
    return np.unique(np.concatenate([group_indices(obj, name) for name in group_names]))


def group_indices(obj, name):
    """Ascending indices of the vertices of weight above 0 in one vertex group."""
    return np.array(steps.members(obj, name), dtype=int)


def result_key(obj):
    """The shape key that the add-on wrote."""
    return obj.data.shape_keys.key_blocks[obj.meanvalue.result_key]
