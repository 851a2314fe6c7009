# SPDX-License-Identifier: GPL-3.0-or-later
"""Two clips for a farm, their plan, and what a single process bakes of them."""

import bpy

from . import handles, meshes
from .baking import animated_tube, bake, key_control, save

FRAMES = 60  # more than one run of the solver, so that runs fade into each other


def two_clips(tmp_path):
    """A saved file with two animated tubes of their own animation."""
    animated_tube("First", FRAMES)
    second, control = handles.tube("Second", live=False)
    second.location.x = 4.0
    bpy.context.view_layer.update()
    key_control(control, FRAMES, reach=-1.0)
    bpy.context.scene.frame_set(1)
    meshes.activate(second)
    return save(tmp_path)


def baked_at_once(tmp_path, name):
    """The bytes of the point cache that the operator writes."""
    meshes.activate(bpy.data.objects[name])
    bake(path=str(tmp_path / "at_once" / f"{name}.pc2"))
    return (tmp_path / "at_once" / f"{name}.pc2").read_bytes()


def planned(tmp_path, part, names=("First", "Second"), chunk=20):
    """OUT with the plan of the scene that is open."""
    out = tmp_path / "out"
    clips = part("baking.bridge.farm_scene").planned(list(names), None)
    part("baking.bridge.farm").write_plan(out, clips, chunk)
    return out
