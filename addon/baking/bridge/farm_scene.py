# SPDX-License-Identifier: GPL-3.0-or-later
"""What a farm is to bake, read from the scene."""

import re

import bpy

from ...errors import SceneError
from ...live import engine
from ...posing.bridge.posing import Posing
from ...scene import mesh_arrays, subject
from ...solver.core.steps import result_of
from ..core import bake_times, frame_ranges
from . import sampling
from .plan import BakePlan


def planned(wanted, frames, portable=False):
    """[(name, BakePlan, triangles)] of clips as --clip writes them; None: every object with handles.

    portable: to be solved with the same bits on every processor of an architecture.

    @throws SceneError.
    """
    scene = bpy.context.scene
    frames = frames or f"{scene.frame_start}..{scene.frame_end}"
    if not wanted:
        wanted = [obj.name for obj in scene.objects if obj.type == "MESH" and obj.meanvalue.handles]
        if not wanted:
            raise SceneError("No object of the scene has handles")
    clips = [_clip(text, frames) for text in wanted]
    names = [name for name, _, _ in clips]
    if len(set(names)) < len(names):
        raise SceneError(f"Two clips have one name: {', '.join(names)}. Give them names: --clip NAME=OBJECT:FRAMES")
    return [(name, *_plan(scene, obj, numbers, portable)) for name, obj, numbers in clips]


def _clip(text, frames):
    """(name, object, first and last frame) of NAME, NAME=OBJECT or NAME=OBJECT:FRAMES."""
    name, _, rest = text.partition("=")
    object_name, own_frames = rest or name, frames
    if rest and rest not in bpy.data.objects and ":" in rest:
        object_name, _, own_frames = rest.rpartition(":")
    obj = bpy.data.objects.get(object_name)
    if obj is None:
        raise SceneError(f"There is no object '{object_name}'")
    problem = subject.object_problem(obj) or subject.mode_problem(obj)
    if problem:
        raise SceneError(problem)
    runs = frame_ranges.runs(frame_ranges.parse(own_frames))
    if len(runs) != 1:
        raise SceneError(f"A clip has no gaps, but {own_frames} has. Give each part a name of its own")
    return re.sub(r"[^\w.-]", "_", name).lstrip(".-") or "clip", obj, runs[0]


def _plan(scene, obj, numbers, portable):
    bind_input = Posing.to_bake(obj).bind_input
    triangles = mesh_arrays.triangles(obj.data, bind_input.rest)
    times = bake_times.sample_times(*numbers)
    with engine.held():
        samples = result_of(sampling.sample(scene.name, lambda: obj, bind_input, times))
    for note in samples.notes:
        print(f"meanvalue: {obj.name}: {note}", flush=True)
    return BakePlan(bind_input, times, 1.0, samples.targets, samples.weights, portable), triangles
