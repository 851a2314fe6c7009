# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning the add-on off and on again."""

import importlib.util
import os
import pathlib
import subprocess
import sys
import urllib.parse
import urllib.request

import bpy
import pytest
from support import installed, meshes, steps

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


def menu_entries():
    return [
        draw.__name__
        for menu in (bpy.types.VIEW3D_MT_object, bpy.types.VIEW3D_MT_edit_mesh)
        for draw in menu.draw._draw_funcs
        if draw.__name__.startswith("meanvalue_")
    ]


def shortcuts():
    """(keymap, operator) of all shortcuts that call the add-on."""
    keyconfig = bpy.context.window_manager.keyconfigs.addon
    return [
        (keymap.name, item.idname)
        for keymap in (keyconfig.keymaps if keyconfig else [])
        for item in keymap.keymap_items
        if "meanvalue" in item.idname + str(getattr(item.properties, "data_path", ""))
        if not keymap.name.startswith("3D View Tool:")
    ]


def test_off_and_on_again_leaves_one_of_everything(part):
    before, handlers_before = registered(), our_handlers()
    assert len(handlers_before) == len(set(handlers_before)) == 4 and len(menu_entries()) == 2
    installed.disable()
    assert our_handlers() == registered() == menu_entries() == shortcuts() == []
    assert not hasattr(bpy.types.Object, "meanvalue") and part("widgets.overlay")._handler is None
    installed.enable()
    assert our_handlers() == handlers_before and registered() == before and len(menu_entries()) == 2


def test_register_and_unregister_by_hand():
    addon = sys.modules[installed.PACKAGE]
    handlers_before, shortcuts_before = our_handlers(), shortcuts()
    for _ in range(3):
        addon.unregister()
        addon.register()
    assert our_handlers() == handlers_before
    assert shortcuts() == shortcuts_before
    assert menu_entries() == ["meanvalue_draw_object_menu", "meanvalue_draw_edit_mesh_menu"]


def test_shortcuts_are_those_that_are_told(part):
    if bpy.context.window_manager.keyconfigs.addon is None:
        pytest.skip("this Blender has no shortcuts of add-ons in the background")
    known = part("posing.ui.grab_tool").SHORTCUTS
    assert sorted(shortcuts()) == sorted((keymap, operator) for keymap, operator, *_ in known)


#: Keymaps that get a key before, or in place of, the keymap of a mode.
ABOVE = ("Window", "Screen", "Screen Editing", "Region Context Menu", "View2D Buttons List", "User Interface")
BELOW = ("Object Non-modal", "3D View", "3D View Generic", "Frames")


def blenders_own_keymap():
    """[(name, what it is for, {"items": [...]})] of Blender's default keymap, which the background does not load."""
    path = pathlib.Path(bpy.utils.preset_find("Blender", "keyconfig")).parent / "keymap_data" / "blender_default.py"
    spec = importlib.util.spec_from_file_location("blender_default", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.generate_keymaps(module.Params())


def test_shortcuts_are_free_in_blenders_own_keymap(part):
    taken = {
        (name, event["type"], *(bool(event.get(modifier)) for modifier in ("ctrl", "alt", "shift")))
        for name, _space, content in blenders_own_keymap()
        for _operator, event, _properties in content["items"]
    }
    assert ("Mesh", 'P', False, False, False) in taken
    for keymap, operator, _properties, key, modifiers in part("posing.ui.grab_tool").SHORTCUTS:
        for name in (keymap, *ABOVE, *BELOW):
            wanted = (name, key, *(modifiers.get(modifier, False) for modifier in ("ctrl", "alt", "shift")))
            assert wanted not in taken, operator


def test_handlers_of_a_former_copy_are_replaced():
    def meanvalue_scene_updated(*_):
        raise AssertionError("a handler of the former add-on was called")

    addon = sys.modules[installed.PACKAGE]
    before = our_handlers()
    addon.unregister()
    bpy.app.handlers.depsgraph_update_post.append(meanvalue_scene_updated)
    addon.register()
    assert meanvalue_scene_updated not in bpy.app.handlers.depsgraph_update_post
    assert our_handlers() == before


def test_a_room_fails_at_once_for_a_wrong_name_and_where_it_lacks_what_a_contract_wants(part):
    make = part("rooms").Room
    with pytest.raises(TypeError, match="scene_updatet"):
        make(page="grab", modules=(), scene_updatet=[print])
    unfinished = type("Unfinished", (part("live.following").Following,), {})
    for lacking in ({"followers": [unfinished]}, {"bakeables": [part("scene.baked")]}, {"shown_keys": [part("ids")]}):
        with pytest.raises(TypeError, match="contract"):
            make(page="grab", modules=(), **lacking)


def test_settings_are_still_there_after_off_and_on():
    obj = steps.posed_grid(meshes.grid())
    installed.disable()
    installed.enable()
    assert obj.meanvalue.bound.is_bound
    steps.solve()


def test_every_operator_has_a_tooltip_a_page_and_an_undo_step():
    names = [name for name in registered() if "_OT_" in name]
    assert len(names) > 5
    for name in names:
        kind = getattr(bpy.types, name)
        assert name == "MEANVALUE_OT_copy_system_info" or 'UNDO' in kind.bl_options, name
        rna = getattr(bpy.ops.meanvalue, kind.bl_idname.split(".")[1]).get_rna_type()
        assert len(rna.description) > 20 and not rna.description.endswith(".")
        assert bpy.types.WM_OT_doc_view_manual._lookup_rna_url(f"bpy.ops.{kind.bl_idname}"), "its page of the guide"
        assert all(each.description or each.is_hidden for each in list(rna.properties)[1:]), name


def test_version_is_that_of_the_solver(native):
    assert native.__version__ == ".".join(map(str, sys.modules[installed.PACKAGE].bl_info["version"]))


def test_a_legacy_copy_has_no_manifest():
    """With one, Blender 4.2 would take the zip for an extension."""
    if installed.IS_EXTENSION:
        pytest.skip("this is the extension")
    assert not pathlib.Path(sys.modules[installed.PACKAGE].__path__[0], "blender_manifest.toml").exists()


@pytest.mark.parametrize(
    "asked", ["ops.meanvalue.bake", "types.MEANVALUE_PG_mix.is_on", "types.MEANVALUE_PG_settings.live"]
)
def test_f1_opens_a_page_of_the_guide_that_is_there(asked):
    url = bpy.types.WM_OT_doc_view_manual._lookup_rna_url(f"bpy.{asked}")
    for each in (url, installed.part("manual").START):
        page = pathlib.Path(urllib.request.url2pathname(urllib.parse.urlparse(each).path))
        assert page.is_relative_to(installed.folder()) and "<h1" in page.read_text()


@pytest.mark.slow
@pytest.mark.skipif(not bpy.app.binary_path, reason="the bpy module starts no Blender")
def test_blender_without_a_window_starts_with_it_turned_on(tmp_path):
    """As on a farm, where the preferences have it: Blender turns it on before it has a keymap."""
    folders = {name: tmp_path / name.lower() for name in ("SCRIPTS", "CONFIG", "RESOURCES", "EXTENSIONS")}
    for folder in folders.values():
        folder.mkdir()
    environment = {**os.environ, **{f"BLENDER_USER_{name}": str(folder) for name, folder in folders.items()}}

    def run(*lines):
        """Lines of Python in a Blender of its own."""
        command = [bpy.app.binary_path, "-b", "-noaudio", "--python-exit-code", "1", "--python-expr"]
        command += ["\n".join(["import bpy", *lines])]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
        assert done.returncode == 0 and "Traceback" not in done.stdout + done.stderr, done.stdout + done.stderr

    if installed.IS_EXTENSION:
        installed.install_by_command(bpy.app.binary_path, environment)
    else:
        run(
            f"bpy.ops.preferences.addon_install(filepath={installed.ZIP!r})",
            f"bpy.ops.preferences.addon_enable(module={installed.PACKAGE!r})",
            "bpy.ops.wm.save_userpref()",
        )
    run("bpy.ops.mesh.primitive_monkey_add()", "assert bpy.ops.meanvalue.grab(vertex=0, pin=True) == {'FINISHED'}")
