# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on that is tested: the zip named by MEANVALUE_ADDON_ZIP, installed as artists install it.

A zip with a manifest is an extension (Blender 4.2 and later), one without is a legacy add-on; each has a package name
of its own.
"""

import importlib
import os
import pathlib
import subprocess
import sys
import zipfile

ZIP = os.environ.get("MEANVALUE_ADDON_ZIP")
REPOSITORY = "user_default"
INSTALL_SECONDS = 300


def _is_extension():
    if not ZIP or not pathlib.Path(ZIP).is_file():
        return False
    with zipfile.ZipFile(ZIP) as archive:
        return "blender_manifest.toml" in archive.namelist()


IS_EXTENSION = _is_extension()
PACKAGE = f"bl_ext.{REPOSITORY}.meanvalue" if IS_EXTENSION else "meanvalue_deform"


def part(name):
    """A module of the installed add-on, as part("live.engine")."""
    return importlib.import_module(f"{PACKAGE}.{name}")


def folder():
    """Where it is installed. Only for use inside Blender."""
    import bpy

    if IS_EXTENSION:
        return pathlib.Path(bpy.utils.user_resource('EXTENSIONS'), REPOSITORY, PACKAGE.rpartition(".")[2]).resolve()
    return pathlib.Path(bpy.utils.user_resource('SCRIPTS'), "addons", PACKAGE).resolve()


def install():
    """By Blender's own means into the user's folder, where no copy may be yet, and enables it."""
    import bpy

    assert not folder().exists(), f"{folder()} is not clean"
    assert PACKAGE not in sys.modules
    if not IS_EXTENSION:
        bpy.ops.preferences.addon_install(filepath=ZIP)
    elif bpy.app.binary_path:
        install_by_command(bpy.app.binary_path)
    else:  # the module has no command line
        bpy.ops.extensions.package_install_files(filepath=ZIP, repo=REPOSITORY, enable_on_install=False)
    enable()
    assert pathlib.Path(sys.modules[PACKAGE].__file__).resolve().parent == folder()


def install_by_command(blender, environment=None):
    """An extension, as a farm would. A Blender that runs already does not find its wheel until all are enabled anew."""
    command = [blender, "--command", "extension", "install-file", "-r", REPOSITORY, "--enable", ZIP]
    done = subprocess.run(command, capture_output=True, text=True, timeout=INSTALL_SECONDS, env=environment)
    assert done.returncode == 0, done.stdout + done.stderr


def enable(package=PACKAGE):
    import bpy

    assert bpy.ops.preferences.addon_enable(module=package) == {'FINISHED'}


def disable(package=PACKAGE):
    import bpy

    assert bpy.ops.preferences.addon_disable(module=package) == {'FINISHED'}
