# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking without an interface, on one machine or many; docs/guide/baking.md, "On a farm".

    blender -b SCENE.blend --python-exit-code 1 --python meanvalue_farm.py -- plan --out DIR --chunk 200
    blender -b --python-exit-code 1 --python meanvalue_farm.py -- bake --plan DIR/plan --index 0

All but plan run in a plain Python, too, where the compiled module can be loaded.
"""

import pathlib
import sys


def main():
    folder = pathlib.Path(__file__).resolve().parent
    sys.path.insert(0, str(folder.parent))
    package = __import__(folder.name)
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]
    if "bpy" in sys.modules and arguments[:1] == ["plan"]:
        import bpy

        if not hasattr(bpy.types.Object, "meanvalue"):  # the add-on is not enabled here, and need not be
            package.register()
    farm = __import__(f"{folder.name}.bake.farm", fromlist=["main"])
    return farm.main(arguments)


if __name__ == "__main__":
    sys.exit(main())
