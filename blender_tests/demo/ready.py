# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes of what the demo has posed and photographed a file to go on with: open it, move a control, the mesh follows."""

import bpy
import numpy as np

from . import photograph, pose


def to_be_tried(subject):
    """Handles with controls where the anchors are posed, pins where they are at rest, Live on, the pose shown.

    The spheres of the pictures, which would stay behind, are hidden. The last control is active and selected.
    """
    obj = subject.obj
    view_layer = bpy.context.view_layer
    rest, shown = pose.positions(obj), pose.positions(obj, pose.result_key(obj))
    while len(obj.meanvalue.handles):
        pose.call(bpy.ops.meanvalue.remove_handle)
    for name in subject.handles:
        members = pose.group_indices(obj, name)
        view_layer.objects.active = obj  # Add Handle makes its control the active one
        if np.allclose(rest[members], shown[members]):
            pose.call(bpy.ops.meanvalue.add_handle, pin=True, group=name)
        else:
            pose.call(bpy.ops.meanvalue.add_handle, group=name)
    kept = (obj.data.shape_keys.reference_key, pose.result_key(obj))
    for key in [key for key in obj.data.shape_keys.key_blocks if key not in kept]:
        obj.shape_key_remove(key)  # the pose key, which nothing follows any more
    for other in bpy.data.objects:
        if other.name.startswith(photograph.MARKS):
            other.hide_viewport = other.hide_render = True
    view_layer.update()
    look_through_camera()


def look_through_camera():
    """The 3D Views look through the camera."""
    for area in (area for screen in bpy.data.screens for area in screen.areas if area.type == 'VIEW_3D'):
        area.spaces.active.region_3d.view_perspective = 'CAMERA'
