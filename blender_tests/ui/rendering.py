# SPDX-License-Identifier: GPL-3.0-or-later
"""A render of an animation while a mesh is live: it must be told, since the mesh stays as it is."""

import bpy
from support import handles, installed


def an_animation_with_live_on(ui):
    obj, control = handles.tube()
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
    text, is_problem = installed.part("live.engine").status(obj)
    assert not is_problem and "animated" in text and "Stop" not in text, text
