# SPDX-License-Identifier: GPL-3.0-or-later
"""A render of an animation while a mesh is live: it must be told, since the mesh stays as it is."""

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
    views, popped_up = installed.part("scene.views"), []
    pop_up = views.pop_up

    def listening(title, text):
        popped_up.append(text)
        pop_up(title, text)

    views.pop_up = listening
    try:
        yield from ui.wait_until(lambda: popped_up, "the popup")
        assert "'Tube'" in popped_up[0] and "Bake" in popped_up[0], popped_up
    finally:
        yield from ui.wait_until(lambda: not bpy.app.is_job_running('RENDER'), "the render ended")
        views.pop_up = pop_up
    yield from ui.screenshot("render_with_live_on")
    assert len(popped_up) == 1, popped_up


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
