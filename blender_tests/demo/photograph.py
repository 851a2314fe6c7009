# SPDX-License-Identifier: GPL-3.0-or-later
"""Before and after: the same object and camera, two poses, markers, pictures side by side."""

import bpy
import numpy as np

from . import markers, pictures, pose, stage

#: What the names of the spheres in the pictures begin with.
MARKS = ("Anchors ", "Border ")


def photograph(subject, picture, output):
    """Renders rest shape and result; returns the names of the PNG files in `output`.

    Leaves the scene showing the result.
    """
    poses = {"before": 0.0, "after": 1.0}
    points = {name: posed_points(subject.obj, value) for name, value in poses.items()}
    everything = np.concatenate(list(points.values()))
    stage.set_stage(everything, picture, subject.view.azimuth_deg, subject.view.elevation_deg)
    marks = {name: add_markers(subject, points[name], name, everything) for name in poses}

    shots = []
    for name, value in poses.items():
        show_pose(subject.obj, value)
        for other, objects in marks.items():
            for obj in objects:
                obj.hide_render = obj.hide_viewport = other != name
        bpy.context.view_layer.update()
        path = output / f"{subject.file_stem}_{name}.png"
        shots.append(stage.render(path))
    both = output / f"{subject.file_stem}_before_after.png"
    pictures.write_png(both, pictures.side_by_side(shots))
    return [*(f"{subject.file_stem}_{name}.png" for name in poses), both.name]


def show_pose(obj, value):
    """Shows the rest shape (0), or the add-on's result alone (1)."""
    result = pose.result_key(obj)
    for key in obj.data.shape_keys.key_blocks:
        if key != obj.data.shape_keys.reference_key:
            key.value = value if key == result else 0.0
    obj.data.update_tag()


def posed_points(obj, value):
    """(n, 3) world positions of the object as it is rendered, modifiers included."""
    show_pose(obj, value)
    return pose.seen_in_world(obj)


def add_markers(subject, points, pose_name, everything):
    """Spheres at the anchors and along the region's border; none where modifiers change the vertex count."""
    obj = subject.obj
    if len(points) != len(obj.data.vertices):
        return []
    diagonal = float(np.linalg.norm(everything.max(axis=0) - everything.min(axis=0)))
    anchors = pose.held(obj)
    objects = [markers.add_anchor_spheres(f"{MARKS[0]}{pose_name}", points[anchors], diagonal)]
    if obj.meanvalue.roi_group:
        roi = np.zeros(len(points), dtype=bool)
        roi[pose.group_indices(obj, obj.meanvalue.roi_group)] = True
        border = markers.border_vertices(obj, roi)
        if len(border):
            objects.append(markers.add_border_spheres(f"{MARKS[1]}{pose_name}", points[border], diagonal))
    return objects
