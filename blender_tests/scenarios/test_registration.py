# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning the add-on off and on again."""

import pathlib
import sys

import bpy
from support import meshes, steps

MODULE = "meanvalue_deform"
HANDLER_LISTS = ("depsgraph_update_post", "undo_post", "redo_post", "load_post")


def our_handlers():
    return sorted(
        f"{name}: {handler.__name__}"
        for name in HANDLER_LISTS
        for handler in getattr(bpy.app.handlers, name)
        if handler.__name__.startswith("meanvalue_")
    )


def registered():
    return [name for name in dir(bpy.types) if name.startswith("MEANVALUE_")]


def test_off_and_on_again_leaves_one_of_everything():
    before, handlers_before = registered(), our_handlers()
    assert len(handlers_before) == len(set(handlers_before)) == 4
    bpy.ops.preferences.addon_disable(module=MODULE)
    assert our_handlers() == []
    assert registered() == []
    assert not hasattr(bpy.types.Object, "meanvalue")
    bpy.ops.preferences.addon_enable(module=MODULE)
    assert our_handlers() == handlers_before
    assert registered() == before


def test_register_and_unregister_by_hand():
    addon = sys.modules[MODULE]
    handlers_before = our_handlers()
    for _ in range(3):
        addon.unregister()
        addon.register()
    assert our_handlers() == handlers_before


def test_handlers_of_a_former_copy_are_replaced():
    def meanvalue_mark_edited(*_):
        raise AssertionError("a handler of the former add-on was called")

    addon = sys.modules[MODULE]
    before = our_handlers()
    addon.unregister()
    bpy.app.handlers.depsgraph_update_post.append(meanvalue_mark_edited)
    addon.register()
    assert meanvalue_mark_edited not in bpy.app.handlers.depsgraph_update_post
    assert our_handlers() == before


def test_handlers_stay_when_a_file_is_opened(tmp_path):
    before = our_handlers()
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "empty.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "empty.blend"))
    assert our_handlers() == before


def test_settings_are_still_there_after_off_and_on():
    obj = steps.posed_grid(meshes.grid())
    bpy.ops.preferences.addon_disable(module=MODULE)
    bpy.ops.preferences.addon_enable(module=MODULE)
    assert obj.meanvalue.bound.is_bound
    steps.solve()


def test_every_operator_has_a_tooltip_and_an_undo_step():
    names = [name for name in registered() if "_OT_" in name]
    assert len(names) > 5
    for name in names:
        kind = getattr(bpy.types, name)
        assert {'REGISTER', 'UNDO'} <= kind.bl_options
        description = getattr(bpy.ops.meanvalue, kind.bl_idname.split(".")[1]).get_rna_type().description
        assert len(description) > 20 and not description.endswith(".")


def test_version_is_that_of_the_manifest():
    addon = sys.modules[MODULE]
    manifest = pathlib.Path(addon.__path__[0], "blender_manifest.toml").read_text(encoding="utf-8")
    assert f'version = "{".".join(map(str, addon.bl_info["version"]))}"' in manifest
