# SPDX-License-Identifier: GPL-3.0-or-later
"""How well the mesh foretells a marker: each is let go in turn, and its point on the skin compared with where it is
carried when it takes part. Without cuffs, which are laid by all the markers of a limb."""

import contextlib

import bpy
import numpy as np

from .. import pose
from .measures import mm, share

#: Frames of the take that are solved for each.
FIRST, LAST, STEP = 40, 160, 4
WORST = 4


def rows(subject, carried):
    """[(what, figure in words)] of the active object, as `capture.carry()` left it; its match is another one then."""
    obj = bpy.context.view_layer.objects.active
    capture = obj.meanvalue.capture
    capture.use_cuffs = False
    pose.call(bpy.ops.meanvalue.match_markers)
    controls = {pair.name: pair.control for pair in capture.pairs if pair.control}
    frames = range(FIRST, min(LAST, len(carried.shapes)) + 1, STEP)
    errors = []
    for name, vertex, wanted in zip(carried.names, carried.anchors, carried.targets.transpose(1, 0, 2), strict=True):
        with let_go(controls[name]):
            pose.call(
                bpy.ops.meanvalue.bake,
                target="POINT_CACHE",
                frame_range="OWN",
                frame_start=frames[0],
                frame_end=frames[-1],
                step=STEP,
                confirm=True,
            )
        places = []
        for frame in frames:
            bpy.context.scene.frame_set(frame)
            places.append(pose.seen_in_world(obj)[vertex])
        errors.append(np.linalg.norm(np.array(places) - wanted[np.array(frames) - 1], axis=1))
        print(f"  without {name}: {mm(rms(errors[-1]))} rms, at most {mm(np.nanmax(errors[-1]))}", flush=True)
    each = np.array([rms(of_marker) for of_marker in errors])
    worst = ", ".join(f"{carried.names[k]} {mm(each[k])}" for k in np.argsort(-each)[:WORST])
    told = f"rms {share(rms(np.array(errors)), subject.height)}, median of the markers {mm(float(np.median(each)))}"
    return [("a marker by the others", f"{told}; least surely: {worst}")]


@contextlib.contextmanager
def let_go(control):
    """Inside, the soft handle of a control is free, whatever its curves say."""
    animation = control.animation_data
    curves = animation.action.fcurves if animation is not None and animation.action is not None else ()
    curves = [curve for curve in curves if curve.data_path == "meanvalue.influence" and not curve.mute]
    before = control.meanvalue.influence
    for curve in curves:
        curve.mute = True
    control.meanvalue.influence = 0.0
    try:
        yield
    finally:
        control.meanvalue.influence = before
        for curve in curves:
            curve.mute = False


def rms(distances):
    return float(np.sqrt(np.nanmean(distances**2)))
