# SPDX-License-Identifier: GPL-3.0-or-later
"""A render of an animation while a mesh is live: it must be told, since the mesh stays as it is."""

from unittest import mock

import bpy
import numpy as np
from harness import view
from live_surprises import slowly
from support import handles, installed
from support.interface import is_settled


def an_animation_with_live_on(ui):
    _obj, control = handles.tube()
    ui.frame_all()
    yield from ui.open_tab("Mean-Value")
    for frame, offset in ((1, 0.0), (40, 4.0)):
        control.location.x += offset
        control.keyframe_insert("location", frame=frame)
    scene = bpy.context.scene
    scene.frame_set(1)
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine = 'CYCLES'
    scene.cycles.samples, scene.cycles.use_denoising = 1, False
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.filepath = bpy.app.tempdir + "frame_"
    scene.frame_start, scene.frame_end = 1, 40
    bpy.context.preferences.view.render_display_type = 'NONE'
    bpy.ops.render.render('INVOKE_DEFAULT', animation=True)
    views = installed.part("scene.views")
    with mock.patch.object(views, "pop_up", wraps=views.pop_up) as pop_up:
        yield from ui.wait_until(lambda: pop_up.called, "the popup")
        yield from ui.wait_until(lambda: not bpy.app.is_job_running('RENDER'), "the render ended")
    yield from ui.screenshot("render_with_live_on")
    ((_title, text), _options) = pop_up.call_args
    assert pop_up.call_count == 1 and "'Tube'" in text and "Bake" in text, pop_up.call_args_list


def the_viewport_with_live_on(ui):
    """Each frame shows the settled answer, however long that takes."""
    obj, control = handles.tube()
    ui.frame_all()
    scene, right, captured = bpy.context.scene, {}, {}
    for frame in range(1, 5):
        control.location.x, control.rotation_euler.x = 1.5 * frame, 0.8 * frame
        control.keyframe_insert("location", frame=frame)
        control.keyframe_insert("rotation_euler", frame=frame)
    for frame in range(1, 5):
        scene.frame_set(frame)
        yield from ui.wait_until(lambda: is_settled(obj), "it is settled")
        right[frame] = handles.shown(obj)
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.filepath = bpy.app.tempdir + "shown_"
    scene.frame_start, scene.frame_end = 1, 4
    bpy.context.preferences.view.render_display_type = 'NONE'

    def capture(_scene, _depsgraph):
        captured[scene.frame_current] = handles.shown(obj)

    bpy.app.handlers.frame_change_post.append(capture)
    try:
        with slowly(0.1):
            for way in ('EXEC_DEFAULT', 'INVOKE_DEFAULT'):
                captured.clear()
                with view.override():
                    bpy.ops.render.opengl(way, animation=True)
                yield from ui.wait_until(lambda: len(captured) == 4, "all frames are rendered")
                off = {frame: float(np.abs(captured[frame] - right[frame]).max()) for frame in right}
                assert max(off.values()) < 1e-2, (way, off)
                yield from ui.pause(1.0)
    finally:
        bpy.app.handlers.frame_change_post.remove(capture)
