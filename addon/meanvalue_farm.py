# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking without an interface, on one machine or many; docs/guide/baking.md, "On a farm".

    blender -b SCENE.blend --python-exit-code 1 --python meanvalue_farm.py -- plan --out DIR --chunk 200
    blender -b --python-exit-code 1 --python meanvalue_farm.py -- bake --plan DIR/plan --index 0

All but plan run in a plain Python, too, where the compiled module can be loaded.
"""

import importlib.util
import pathlib
import sys

FOLDER = pathlib.Path(__file__).resolve().parent
ALONE = "meanvalue_deform"


def addon():
    """Name of the package around this file, once it is imported."""
    for name, module in list(sys.modules.items()):
        if str(getattr(module, "__file__", None)) == str(FOLDER / "__init__.py"):
            return name
    return _enabled_extension() or _alone()


def _enabled_extension():
    """Where this is an extension of the Blender that runs: enabled, which also puts its wheels in place. Else None."""
    if "bpy" not in sys.modules:
        return None
    import addon_utils
    import bpy

    repositories = getattr(bpy.context.preferences, "extensions", None)  # Blender 4.2 and later
    for repository in repositories.repos if repositories else ():
        if pathlib.Path(repository.directory).resolve() == FOLDER.parent:
            name = f"bl_ext.{repository.module}.{FOLDER.name}"
            return name if addon_utils.enable(name) else None
    return None


def _alone():
    """Not under the folder's name: an extension's folder is called as the compiled module, and would hide it."""
    init, folders = FOLDER / "__init__.py", [str(FOLDER)]
    spec = importlib.util.spec_from_file_location(ALONE, init, submodule_search_locations=folders)
    package = sys.modules[ALONE] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(package)
    return ALONE


def main():
    package = addon()
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if "bpy" in sys.modules and arguments[:1] == ["plan"]:
        import bpy

        if not hasattr(bpy.types.Object, "meanvalue"):  # the add-on is not enabled here, and need not be
            sys.modules[package].register()
    return __import__(f"{package}.baking.bridge.farm", fromlist=["main"]).main(arguments)


if __name__ == "__main__":
    sys.exit(main())
