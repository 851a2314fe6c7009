# SPDX-License-Identifier: GPL-3.0-or-later
"""From the capture's files to the baked mesh, by the operators alone, as an artist's clicks would."""

import time
from dataclasses import dataclass

import bpy
import numpy as np

from .. import pose, scene_mesh

BODY_COLOUR = (0.52, 0.40, 0.33)


@dataclass(frozen=True, eq=False)
class Carried:
    """A mesh that was moved through f frames.

    shapes (f, n, 3) float32 as Blender plays them; anchors (m,) vertices; targets (f, m, 3) where they were to go, NaN
    where they were free; balls (f, m, 3) where the markers are, NaN where they were not seen; matched (m,) metres from
    marker to surface in the reference; seconds {stage: seconds}; all in world space.
    """

    shapes: np.ndarray
    anchors: np.ndarray
    targets: np.ndarray
    balls: np.ndarray
    matched: np.ndarray
    seconds: dict


def carry(subject, folder):
    """Makes the mesh in the scene, imports, matches and bakes it, saves the .blend. @throws DemoError."""
    seconds = {}
    blend = folder / f"{subject.stem}.blend"
    obj = scene_mesh.new_object(subject.stem, subject.vertices, subject.polygons)
    scene_mesh.shade_smooth(obj)
    obj.data.materials.append(scene_mesh.plain_material("Skin", BODY_COLOUR, 0.55))
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.ops.wm.save_as_mainfile(filepath=str(blend), check_existing=False)

    for left in (folder / "meanvalue_cache" / subject.stem).glob(f"{subject.stem}.pc2*"):
        left.unlink()  # else Bake would say that nothing has changed, and be timed for that

    at = time.perf_counter()
    bring_in(subject, obj)
    seconds["import"] = -at + (at := time.perf_counter())
    pose.call(bpy.ops.meanvalue.match_markers)
    seconds["match"] = -at + (at := time.perf_counter())
    pose.call(bpy.ops.meanvalue.bake, target="POINT_CACHE", frame_range="SCENE", confirm=True)
    seconds["bake"] = -at + (at := time.perf_counter())
    result = play(obj, seconds)
    seconds["play"] = -at + time.perf_counter()
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)
    bpy.ops.wm.save_mainfile()
    return result


def bring_in(subject, obj):
    """Imports motion and reference: the mesh is active, so the first becomes its take."""
    scene, capture = bpy.context.scene, obj.meanvalue.capture
    pose.call(bpy.ops.meanvalue.import_motion, filepath=str(subject.take), time="CAPTURE")
    scene.frame_end = scene.frame_start + capture.take.meanvalue.sample_count - 1
    before = set(bpy.data.collections)
    if subject.standing is not None:
        pose.call(bpy.ops.meanvalue.import_motion, filepath=str(subject.standing), extend_range=False)
        (capture.reference_take,) = set(bpy.data.collections) - before
    capture.mode = subject.mode
    capture.use_low_pass, capture.cutoff_hz = True, subject.low_pass_hz


def play(obj, seconds):
    """Goes through the frames and looks: the Carried."""
    scene, capture = bpy.context.scene, obj.meanvalue.capture
    pairs = [pair for pair in capture.pairs if pair.control]
    empties = {empty.meanvalue.marker: empty for empty in capture.take.objects}
    alignment = np.array(obj.matrix_world) @ np.array(capture.alignment).reshape(4, 4)
    shapes, targets, captured = [], [], []
    for frame in range(scene.frame_start, scene.frame_end + 1):
        scene.frame_set(frame)
        shapes.append(pose.seen_in_world(obj))
        targets.append([place(pair.control) for pair in pairs])
        captured.append([place(empties[pair.name]) for pair in pairs])
    targets, captured = np.array(targets), np.array(captured)
    # What was captured is not where a character of other proportions is.
    balls = targets if capture.mode == "RETARGET" else captured @ alignment[:3, :3].T + alignment[:3, 3]
    anchors = np.array([pair.vertex for pair in pairs])
    matched = np.array([pair.distance for pair in pairs])
    return Carried(np.stack(shapes), anchors, targets, balls, matched, seconds)


def place(empty):
    """(3,) in the world, NaN where it is let go."""
    return tuple(empty.matrix_world.translation) if empty.meanvalue.influence >= 1.0 else (np.nan,) * 3
