# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel, the list and the preferences say in each state, drawn into a layout that only listens.

Pictures of the real thing: ui/panel_pictures.py.
"""

import itertools
import time
import types

import bpy
import pytest
from support import installed, meshes, steps
from support.baking import animated_tube
from support.snapshot import assert_same, snapshot


class ListeningLayout:
    """Takes every call of UILayout, for itself and what it contains, and remembers the texts and operators."""

    def __init__(self, told=None):
        self.__dict__["told"] = [] if told is None else told

    def __setattr__(self, _name, _value):
        pass

    def __getattr__(self, name):
        def call(*arguments, **options):
            words = [str(argument) for argument in arguments if isinstance(argument, str)]
            self.told.append(" ".join([name, *words, str(options.get("text", ""))]))
            return ListeningLayout(self.told)

        return call

    @property
    def text(self):
        return "\n".join(self.told)

    @property
    def labels(self):
        return " ".join(line[len("label ") :] for line in self.told if line.startswith("label "))


def context_of(obj):
    return types.SimpleNamespace(
        object=obj,
        preferences=types.SimpleNamespace(system=types.SimpleNamespace(ui_scale=1.0)),  # it is 0 without a window
        region=types.SimpleNamespace(width=300),
    )


@pytest.fixture
def draw(part, monkeypatch):
    """draw(obj): the panel with all its parts drawn for obj, some time after the last edit."""
    panels = part("posing.ui.panel").CLASSES

    later = itertools.count(1)

    def draw(obj):
        bpy.context.view_layer.update()
        monkeypatch.setattr(part("scene.object_model"), "clock", lambda: time.monotonic() + next(later))
        listener = types.SimpleNamespace(layout=ListeningLayout())
        for panel in panels:
            if not hasattr(panel, "poll") or panel.poll(context_of(obj)):
                panel.draw(listener, context_of(obj))
        return listener.layout

    return draw


def test_without_an_object(draw):
    assert "There is no active object. Click a mesh object." in draw(None).labels


def test_with_a_lamp(draw):
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    assert "'Lamp' is not a mesh" in draw(lamp).labels


def test_every_button_is_there(draw):
    text = draw(meshes.grid()).text
    names = (
        "add_handle add_pin remove_handle reset_handles bind unbind solve solve_from_key "
        "keep_pose apply_pose keyframe_handles finish grow_region paint_region"
    )
    for name in names.split():
        assert f"operator meanvalue.{name}" in text
    for name in ("live", "show_overlay", "roi_group", "roi_invert", "method", "rigidity", "result_key"):
        assert name in text


def test_states(draw):
    obj = meshes.grid()
    assert "Choose the Grab tool, press on the mesh and drag" in draw(obj).labels
    steps.list_anchors(obj, A=[0, 4, 20], B=[24])
    assert "To see the mesh follow, press Live, or Bake" in draw(obj).labels
    bpy.ops.meanvalue.bind()
    labels = draw(obj).labels
    assert "Bound: 25 vertices, 4 held, 21 free" in labels
    assert "Only pins hold the mesh" in labels
    steps.add_pose_key(obj)
    steps.move(obj, [24], (0.0, 0.0, 1.0))
    steps.solve()
    labels = draw(obj).labels
    assert "Solved:" in labels and "energy" in labels
    obj.vertex_groups["A"].add([22], 1.0, 'REPLACE')
    assert "Stale: the handles changed. Solve will bind again" in draw(obj).labels
    obj.meanvalue.result_key = "Basis"
    assert "must not be overwritten" in draw(obj).labels


def test_a_bake_that_plays_is_on_top_of_all(draw, tmp_path):
    animated_tube()
    assert bpy.ops.meanvalue.bake(path=str(tmp_path / "tube.pc2")) == {'FINISHED'}
    text = draw(bpy.context.object).text
    assert text.index("A bake plays") < text.index("operator meanvalue.unbake")
    assert text.count("operator meanvalue.unbake") == 2
    assert "operator meanvalue.keep_pose" not in text


def test_edit_mode(draw):
    obj = steps.bound_grid(meshes.grid())
    draw(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    labels = draw(obj).labels
    assert "Bound:" in labels
    assert "is in Edit Mode. Go back to Object Mode." in labels


def test_the_region_while_it_is_painted(draw):
    obj = meshes.grid()
    assert "finish_region" not in draw(obj).text
    bpy.ops.meanvalue.paint_region()
    text = draw(obj).text
    assert "operator meanvalue.paint_region" in text
    assert "paint_region" not in text


def test_an_overlay_that_had_to_stop(draw, part, monkeypatch):
    monkeypatch.setattr(part("widgets.overlay"), "problem", "The overlay cannot be drawn: no reason")
    assert "The overlay cannot be drawn: no reason." in draw(meshes.grid()).labels


def test_menus():
    obj = meshes.grid()
    told = {}
    for menu in bpy.types.Menu.__subclasses__():
        if not menu.__name__.startswith("MEANVALUE_"):
            continue
        listener = types.SimpleNamespace(layout=ListeningLayout(), operators=getattr(menu, "operators", ()))
        menu.draw(listener, context_of(obj))
        told[menu.__name__] = listener.layout.text
    every = {name for name in dir(bpy.types) if name.startswith("MEANVALUE_OT_")}
    in_sidebar_only = {
        "MEANVALUE_OT_add_preset",
        "MEANVALUE_OT_finish_region",
        "MEANVALUE_OT_grab",  # by the tool
        "MEANVALUE_OT_pin_here",
        "MEANVALUE_OT_use_preset",  # for preset files
    }
    for name in every - in_sidebar_only:
        assert f"operator {getattr(bpy.types, name).bl_idname} " in "".join(told.values())
    assert told["MEANVALUE_MT_object"].count("menu MEANVALUE_MT_") == 4
    assert "operator meanvalue.add_handle " in told["MEANVALUE_MT_edit_mesh"]


def test_the_object_menu_has_an_entry_for_meshes_only(part):
    menus = part("posing.ui.menus")
    for obj, expected in ((meshes.grid(), "MEANVALUE_MT_object"), (None, "")):
        listener = types.SimpleNamespace(layout=ListeningLayout())
        menus.meanvalue_draw_object_menu(listener, context_of(obj))
        assert (expected in listener.layout.text) if expected else listener.layout.text == ""


def test_without_the_native_module(draw, part, monkeypatch):
    loader = part("solver.native_loader")
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    loader.forget()
    try:
        layout = draw(meshes.grid())
        assert "Install the add-on zip" in layout.labels
        assert "operator meanvalue.bind" in layout.text
    finally:
        monkeypatch.undo()
        loader.forget()


def test_drawing_changes_nothing(draw):
    obj = steps.posed_grid(meshes.textured_grid())
    before = snapshot(obj)
    draw(obj)
    assert_same(before, snapshot(obj))


def test_list_lines(part):
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20], Gone=[1])
    obj.vertex_groups.remove(obj.vertex_groups["Gone"])
    part("posing.bridge.object_status").status(obj)
    lines = []
    for item in obj.meanvalue.handles:
        layout = ListeningLayout()
        part("posing.ui.handle_list").MEANVALUE_UL_handles.draw_item(
            None, context_of(obj), layout, None, item, 0, None, "", 0
        )
        lines.append(layout.labels)
    assert lines == ["A", "Gone"]


def test_preferences(part, native, monkeypatch):
    preferences = part("preferences").MEANVALUE_AP_preferences
    loader = part("solver.native_loader")
    assert preferences.bl_idname == installed.PACKAGE
    listener = types.SimpleNamespace(layout=ListeningLayout())
    preferences.draw(listener, context_of(None))
    assert f"Ready, version {native.__version__}" in listener.layout.labels
    for _, value in loader.environment():
        assert value in listener.layout.labels
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    loader.forget()
    try:
        listener = types.SimpleNamespace(layout=ListeningLayout())
        preferences.draw(listener, context_of(None))
        assert "Install the add-on zip" in listener.layout.labels
    finally:
        monkeypatch.undo()
        loader.forget()


@pytest.mark.parametrize("width", [50, 200, 1000])
def test_long_texts_are_broken_to_the_width(part, width):
    layout = ListeningLayout()
    context = context_of(None)
    context.region.width = width
    part("widgets.text_box").draw_wrapped(layout, context, "word " * 60, icon='ERROR')
    lines = [line for line in layout.told if line.startswith("label")]
    assert layout.labels.split() == ["word"] * 60
    assert max(len(line) for line in lines) <= max(width // 7, 16) + len("label ")
