# SPDX-License-Identifier: GPL-3.0-or-later
"""Turning the add-on off and on again, updating it, a second copy of it, and what it tells of itself."""

import importlib.util
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse
import urllib.request
import zipfile

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
    before, handlers_before, shortcuts_before = registered(), our_handlers(), shortcuts()
    assert len(handlers_before) == len(set(handlers_before)) == 4
    for _ in range(2):
        installed.disable()
        assert our_handlers() == registered() == menu_entries() == shortcuts() == []
        assert not hasattr(bpy.types.Object, "meanvalue") and part("widgets.overlay")._handler is None
        installed.enable()
        assert our_handlers() == handlers_before and registered() == before and shortcuts() == shortcuts_before
        assert menu_entries() == ["meanvalue_draw_object_menu", "meanvalue_draw_edit_mesh_menu"]


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
    for keymap, operator, _properties, key, modifiers in part("posing.ui.menus").SHORTCUTS:
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
    for each in (url, installed.part("registration").START):
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


# -- the same add-on installed twice, as an extension beside a legacy copy ---------------------------------------------


FIRST = installed.PACKAGE
SECOND = "meanvalue_copy"


@pytest.fixture
def second():
    """A copy of the installed add-on, or of the extension, among the legacy add-ons; off."""
    copy = pathlib.Path(bpy.utils.user_resource('SCRIPTS'), "addons", SECOND)
    shutil.copytree(installed.folder(), copy)
    yield SECOND
    bpy.ops.preferences.addon_disable(module=SECOND)
    shutil.rmtree(copy)
    for name in [name for name in sys.modules if name.split(".")[0] == SECOND]:
        del sys.modules[name]


def homes():
    """{class of ours: its module}"""
    return {name: getattr(bpy.types, name).__module__ for name in dir(bpy.types) if name.startswith("MEANVALUE_")}


def test_the_second_copy_is_refused_and_leaves_the_first(second):
    before = homes()
    with pytest.raises(RuntimeError, match=rf"Another copy of Mean-Value Deform is on \({FIRST}\)"):
        bpy.ops.preferences.addon_enable(module=second)
    assert bpy.ops.preferences.addon_disable(module=second) == {'FINISHED'}
    assert homes() == before
    steps.posed_grid(meshes.grid())
    steps.solve()


def test_turning_the_first_off_and_the_second_on(second):
    assert bpy.ops.preferences.addon_disable(module=FIRST) == {'FINISHED'}
    bpy.ops.preferences.addon_enable(module=second)
    assert all(module.startswith(f"{second}.") for module in homes().values())
    steps.posed_grid(meshes.grid())
    steps.solve()
    bpy.ops.preferences.addon_disable(module=second)
    assert homes() == {}
    assert bpy.ops.preferences.addon_enable(module=FIRST) == {'FINISHED'}


# -- a newer version installed over one that is on and has been used ---------------------------------------------------


NEWER = "9.9.9"


@pytest.fixture
def newer(tmp_path):
    """The tested zip with a higher version, and a mark in a class of it. The tested one is put back after."""
    path = tmp_path / "newer.zip"
    with zipfile.ZipFile(installed.ZIP) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith("blender_manifest.toml"):
                content = re.sub(rb'(?m)^version = ".*"', f'version = "{NEWER}"'.encode(), content)
            elif name.endswith("baking/panel.py"):
                content += f'\nMEANVALUE_PT_bake.MARK = "{NEWER}"\n'.encode()
            new.writestr(name, content)
    yield path
    _install_over(installed.ZIP)
    assert not hasattr(bpy.types.MEANVALUE_PT_bake, "MARK")


def _install_over(path):
    """As from the preferences: a legacy add-on is then off, an extension on."""
    if installed.IS_EXTENSION:
        bpy.ops.extensions.package_install_files(
            filepath=str(path), repo=installed.REPOSITORY, enable_on_install=True, overwrite=True
        )
    else:
        bpy.ops.preferences.addon_install(filepath=str(path), overwrite=True)
        installed.enable()


def test_updating_while_it_is_on(newer):
    obj = steps.posed_grid(meshes.grid())
    steps.solve()
    before = registered()
    _install_over(newer)
    assert bpy.types.MEANVALUE_PT_bake.MARK == NEWER
    assert registered() == before
    assert obj.meanvalue.bound.is_bound
    steps.solve()


# -- Copy System Info: all that a report should say, and nothing of what the artist's things are called ----------------


SECRET = "Zarquon"


def told(capfd):
    assert bpy.ops.meanvalue.copy_system_info() == {'FINISHED'}
    return capfd.readouterr().out if bpy.app.background else bpy.context.window_manager.clipboard


def test_a_posed_object_without_a_name_of_the_artists(native, tmp_path, capfd):
    obj = steps.posed_grid(meshes.grid())
    obj.name = f"{SECRET} body"
    obj.vertex_groups["Tip"].name = f"{SECRET} tip"
    obj.meanvalue.handles["Tip"].name = f"{SECRET} tip"
    obj.modifiers.new(SECRET, 'SUBSURF')
    steps.solve()
    obj.meanvalue.roi_group = steps.add_group(obj, f"{SECRET} region", range(10, 25)).name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{SECRET}.blend"))
    capfd.readouterr()
    text = told(capfd)
    assert SECRET not in text and str(tmp_path) not in text
    for line in (f"Blender: {bpy.app.version_string}", "Vertices, edges, faces: 25, 40, 16", "Modifiers: SUBSURF",
                 "Handles and pins, region: 2, True", "Method: fast", f"Solver: {native.__version__}"):  # fmt: skip
        assert line in text, line


@pytest.mark.parametrize("kind", ["none", "CAMERA", "MESH"])
def test_it_works_wherever_one_is(kind, capfd):
    if kind == "CAMERA":
        bpy.ops.object.camera_add()
    elif kind == "MESH":
        meshes.grid()
        bpy.ops.object.mode_set(mode='EDIT')
    assert f"Active object: {kind}" in told(capfd)
