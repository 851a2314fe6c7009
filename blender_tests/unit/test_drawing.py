# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel, the list and the preferences say in each state, drawn into a layout that only listens.

Pictures of the real thing: ui/panel_pictures.py.
"""

import itertools
import time
import types

import bpy
import pytest
from support import marked_tube, meshes, steps
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
            if name == "template_list":  # or what is below would move under the mouse as it is filled
                assert options["rows"] == options.get("maxrows", 5)
            words = [str(argument) for argument in arguments if isinstance(argument, str)]
            self.told.append(" ".join([name, *words, str(options.get("text", ""))]))
            return ListeningLayout(self.told)

        return call

    @property
    def text(self):
        return "\n".join(self.told)

    @property
    def controls(self):
        """What can be pressed, dragged or filled in; a list is one."""
        kinds = ("operator", "operator_menu_enum", "prop", "prop_search", "prop_enum", "menu", "template_list")
        return [line for line in self.told if line.split()[0] in kinds]

    @property
    def labels(self):
        return " ".join(line[len("label ") :] for line in self.told if line.startswith("label "))


def _grab_tool(_mode, create=False):
    return types.SimpleNamespace(idname="meanvalue.grab", operator_properties=lambda name: name)


def context_of(obj):
    return types.SimpleNamespace(
        object=obj,
        scene=bpy.context.scene,
        selected_objects=[],
        mode='OBJECT' if obj is None else obj.mode,
        workspace=types.SimpleNamespace(tools=types.SimpleNamespace(from_space_view3d_mode=_grab_tool)),
        preferences=types.SimpleNamespace(system=types.SimpleNamespace(ui_scale=1.0)),  # it is 0 without a window
        region=types.SimpleNamespace(width=300),
    )


@pytest.fixture
def draw(part, monkeypatch):
    """draw(obj): what the tab shows of obj, some time after the last edit, with the closed parts that are named opened;
    is_all_open: with all of them."""
    names = [name for name in dir(bpy.types) if name.startswith("MEANVALUE_PT_")]
    panels = [panel for panel in (getattr(bpy.types, name) for name in names) if panel.bl_space_type == 'VIEW_3D']

    later = itertools.count(1)

    def draw(obj, *opened, is_all_open=False):
        bpy.context.view_layer.update()
        monkeypatch.setattr(part("scene.object_model"), "clock", lambda: time.monotonic() + next(later))
        listener = types.SimpleNamespace(layout=ListeningLayout())
        may_close = [panel for panel in panels if 'DEFAULT_CLOSED' in getattr(panel, "bl_options", ())]
        closed = [panel for panel in may_close if panel.bl_label not in opened]
        closed_names = {getattr(panel, "bl_idname", "") for panel in closed} - {""}
        for panel in panels:
            if not is_all_open and (panel in closed or getattr(panel, "bl_parent_id", "") in closed_names):
                continue
            if not hasattr(panel, "poll") or panel.poll(context_of(obj)):
                panel.draw(listener, context_of(obj))
        return listener.layout

    return draw


def test_at_most_8_controls_on_a_fresh_mesh(draw):
    layout = draw(meshes.grid())
    assert 3 <= len(layout.controls) <= 8, layout.controls
    assert "operator meanvalue.grab" in layout.text


def test_at_most_20_controls_with_handles_that_are_matched(draw, tmp_path):
    obj, _take = marked_tube.set_up(tmp_path)
    marked_tube.match()
    obj.meanvalue.live = True
    bpy.context.scene.frame_set(60)
    bpy.ops.meanvalue.keep_pose()
    layout = draw(obj, "Motion Capture")
    assert len(layout.controls) <= 20, layout.controls
    text = layout.text
    for name in ["grab", "remove_handle", "reset_handles", "keyframe_handles", "keep_pose", "drive_by_bone"]:
        assert f"operator meanvalue.{name}" in text
    assert "menu MEANVALUE_MT_apply" in text


def test_the_status_tells_only_what_is_to_be_done(draw):
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20])
    steps.add_handle(obj, "B", [24], live=False)
    meshes.activate(obj)
    bpy.ops.meanvalue.bind()
    assert "operator meanvalue.bind" not in draw(obj).text
    obj.vertex_groups["A"].add([22], 1.0, 'REPLACE')
    assert "operator meanvalue.bind" not in draw(obj).text  # that is taken in by itself
    steps.edit_mesh(obj, lambda bm: bm.verts.new((0.0, 0.0, -3.0)))
    assert "operator meanvalue.bind" in draw(obj).text
    bpy.ops.meanvalue.bind()
    assert "operator meanvalue.bind" not in draw(obj).text
    obj.meanvalue.handles["B"].control = None
    assert "operator meanvalue.bind" in draw(obj).text
    bpy.ops.meanvalue.bind()
    assert obj.meanvalue.handles["B"].control is not None


def test_a_bake_that_plays_is_on_top_of_all(draw, tmp_path):
    animated_tube()
    assert bpy.ops.meanvalue.bake(path=str(tmp_path / "tube.pc2")) == {'FINISHED'}
    text = draw(bpy.context.object).text
    assert text.index("A bake plays") < text.index("operator meanvalue.unbake")
    assert text.count("operator meanvalue.unbake") == 2
    assert "operator meanvalue.keep_pose" not in text


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
    assert len(every) <= 34
    # Scripts outside the project rely on these names.
    for name in ["bind", "unbind", "solve", "add_handle", "apply_pose", "bake", "morph", "import_motion"]:
        assert f"MEANVALUE_OT_{name}" in every
    # By the tool, with shape keys, for scripts.
    elsewhere = {"MEANVALUE_OT_grab", "MEANVALUE_OT_morph", "MEANVALUE_OT_solve", "MEANVALUE_OT_unbind"}
    for name in every - elsewhere:
        assert f"operator {getattr(bpy.types, name).bl_idname} " in "".join(told.values()), name


def test_drawing_changes_nothing(draw):
    obj = steps.posed_grid(meshes.textured_grid())
    before = snapshot(obj)
    draw(obj, is_all_open=True)
    assert_same(before, snapshot(obj))
