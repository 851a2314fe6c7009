# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists do to a mesh with handles beside posing it, and what must not happen then."""

import io
import sys

import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import TOP, move, rest, shown, update
from support.interface import interface


def test_a_failed_solve_is_told_until_the_control_moves(status, part, monkeypatch):
    obj, control = handles.tube()
    session, errors = part("solver.session"), part("errors")
    solve_steps = session.solve_steps

    def fails(*_arguments, **_options):
        raise errors.SolverError("it cannot be reached")
        yield

    monkeypatch.setattr(session, "solve_steps", fails)
    move(control, (1.0, 0.0, 0.0))
    obj.update_tag()
    update()
    assert status(obj)[1] and "it cannot be reached" in status(obj)[0]
    monkeypatch.setattr(session, "solve_steps", solve_steps)
    move(control, (0.5, 0.0, 0.0))
    assert not status(obj)[1]
    assert np.allclose(shown(obj)[TOP] - rest(obj)[TOP], (1.5, 0.0, 0.0), atol=1e-3)


@pytest.mark.parametrize("name, is_relative", [("Other", True), ("Mean-Value", False)])
def test_a_result_that_shows_in_part_or_on_another_key_is_told(status, name, is_relative):
    obj, _control = handles.tube()
    other, key = obj.shape_key_add(name="Other", from_mix=False), obj.data.shape_keys.key_blocks["Mean-Value"]
    if is_relative:
        key.relative_key = other
    else:
        key.value = 0.0
    update()
    text, is_problem = status(obj)
    assert is_problem and f"'{name}'" in text


@pytest.fixture
def asked(part, monkeypatch):
    """What Blender is asked for while a frame is looked at, which it must not be on the thread that renders."""
    names, engine = [], part("live.engine")
    look = engine.rendered_frame

    class Nobody:
        def __getattr__(self, name):
            names.append(name)

    def look_alone(*arguments):
        with monkeypatch.context() as patched:
            patched.setattr(bpy, "context", Nobody())
            patched.setattr(bpy.types.Object, "users_scene", property(lambda _obj: names.append("users_scene")))
            look(*arguments)

    monkeypatch.setattr(engine, "rendered_frame", look_alone)
    return names


@pytest.fixture
def untold(part):
    """What no popup has shown."""
    return part("live.engine").untold


@pytest.mark.parametrize("is_animated", [True, False])
def test_rendering_an_animation_of_a_live_mesh_is_told(status, tmp_path, is_animated, asked, untold):
    obj, control = handles.tube()
    assert status(obj)[0] == ""
    for frame in (1, 3) if is_animated else ():
        control.location.x += frame
        control.keyframe_insert("location", frame=frame)
        assert "export" in status(obj)[0] and "Bake" in status(obj)[0] and not status(obj)[1]
    scene = steps.scene_to_render(tmp_path / "frame_")
    scene.frame_set(1)
    control.parent.keyframe_insert("location", frame=1)  # the object itself may be moved
    control.parent.location.x += 2.0
    control.parent.keyframe_insert("location", frame=3)
    scene.frame_set(1)
    before, rendered = shown(obj), []
    bpy.app.handlers.render_post.append(lambda *_: rendered.append(shown(obj)))
    bpy.ops.render.render(animation=True)
    bpy.app.handlers.render_post.clear()
    assert len(rendered) == 3 and all(np.array_equal(shape, before) for shape in rendered), "it is left as it is"
    assert ["Bake" in each and "'Tube'" in each for each in untold] == is_animated * [True] and not asked
    scene.frame_start = scene.frame_end = scene.frame_current
    bpy.ops.render.render(animation=True)
    assert not untold, "the last render had one frame alone"


def test_a_render_right_after_a_drag_is_told(part, untold):
    """It shows a pose that is not settled."""
    engine = part("live.engine")
    with interface() as timers:
        _obj, control = handles.tube()
        timers.run(0.1)
        engine.meanvalue_render_started()
        assert not untold
        engine.meanvalue_render_ended()
        move(control, (1.0, 0.0, 0.0))
        engine.meanvalue_render_started()
        engine.meanvalue_render_ended()
        assert len(untold) == 1 and "render again" in untold[0]
        untold.clear()  # a popup needs a window


def test_a_control_chosen_in_another_view_layer_makes_its_handle_the_active_one():
    """As in a second window, whose choice is told once."""
    obj, control = handles.tube(live=False)
    settings, top = obj.meanvalue, obj.meanvalue.handles.find("Top")
    other = bpy.context.scene.view_layers.new("Second")

    def moved_in(*layers):
        control.location.x += 0.1
        for layer in layers:
            layer.update()

    meshes.activate(obj)
    moved_in(bpy.context.view_layer, other)
    settings.active_handle = 1 - top
    other.objects.active = other.objects[control.name]
    moved_in(bpy.context.view_layer, other)
    assert settings.active_handle == top
    settings.active_handle = 1 - top
    moved_in(bpy.context.view_layer, other)
    assert settings.active_handle == 1 - top, "the artist's to change"


def test_a_name_that_the_console_has_no_letters_for(part, monkeypatch):
    console = io.TextIOWrapper(io.BytesIO(), encoding="cp1252")
    monkeypatch.setattr(sys, "stdout", console)
    part("live.engine").tell_of_render("'手' was still being solved")
    part("live.engine").forget_renders()
    console.flush()
    assert rb"'\u624b' was still being solved" in console.buffer.getvalue()
