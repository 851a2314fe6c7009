# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of ways of posing: those that come with the add-on, and the artist's own."""

import pathlib
import shutil

import bpy
import pytest
from support import meshes, steps

PANEL = "MEANVALUE_PT_presets"


@pytest.fixture
def shipped(part):
    return sorted(part("ui.presets").SHIPPED.glob("*.py"))


@pytest.fixture(autouse=True)
def no_presets_of_our_own():
    yield
    for folder in bpy.utils.preset_paths("meanvalue"):
        shutil.rmtree(folder)  # with what Python compiled


def execute(path):
    assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname=PANEL) == {'FINISHED'}


def test_those_that_come_with_the_add_on(shipped, part):
    settings = meshes.grid().meanvalue
    found = {}
    for path in shipped:
        settings.method, settings.rigidity = 'full', 77.0
        execute(path)
        found[path.stem] = (settings.method, settings.rigidity)
    ids = part("ids")
    assert found["Default"] == (ids.METHOD_FAST, ids.DEFAULT_RIGIDITY)
    assert found["Soft_Tissue"][1] < found["Default"][1] < found["Stiff"][1]
    assert found["Paper"][0] == ids.METHOD_PAPER
    assert len(set(found.values())) == len(found) == 4


def test_store_use_and_remove_one():
    settings = meshes.grid().meanvalue
    settings.method, settings.rigidity = 'paper', 3.5
    assert bpy.ops.meanvalue.add_preset(name="Wet Cloth, 2") == {'FINISHED'}
    settings.method, settings.rigidity = 'fast', 15.0
    path = bpy.utils.preset_find("Wet_Cloth__2", "meanvalue")
    execute(path)
    assert (settings.method, settings.rigidity) == ('paper', 3.5)
    assert bpy.types.MEANVALUE_PT_presets.bl_label == "Wet Cloth  2"
    shown_as = bpy.path.display_name(path, title_case=False)
    assert bpy.ops.meanvalue.add_preset(name=shown_as, remove_name=True) == {'FINISHED'}
    assert not pathlib.Path(path).exists()


def test_they_are_for_the_mesh_while_its_control_is_active(shipped):
    obj = meshes.grid()
    steps.add_group(obj, "Hand", [12])
    bpy.ops.meanvalue.add_handle(group="Hand", live=False)
    assert bpy.context.object.type == 'EMPTY'
    execute(next(path for path in shipped if path.stem == "Stiff"))
    assert obj.meanvalue.rigidity == 100.0
    assert bpy.context.object.meanvalue.rigidity != 100.0
    obj.meanvalue.rigidity = 4.0
    assert bpy.ops.meanvalue.add_preset(name="Mine") == {'FINISHED'}
    assert "rigidity=4.0" in pathlib.Path(bpy.utils.preset_find("Mine", "meanvalue")).read_text(encoding="utf-8")


def test_refused():
    with steps.refused("no active object"):
        bpy.ops.meanvalue.add_preset(name="Mine")
    meshes.grid()
    for name in ("", "  ", "..."):
        with steps.refused("preset has no name", "Give it one"):
            bpy.ops.meanvalue.add_preset(name=name)
    for name in ("Stiff", "Nowhere"):
        with steps.refused(f"You have stored no preset '{name}'", "cannot be removed"):
            bpy.ops.meanvalue.add_preset(name=name, remove_name=True)


def test_nothing_is_made_by_registering():
    assert bpy.utils.preset_paths("meanvalue") == []
