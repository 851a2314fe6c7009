# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests inside Blender start from: the installed add-on, enabled, in an empty file.

Tests in host/ need no Blender and none of this.
"""

import importlib
import os
import pathlib
import shutil
import sys

import pytest

PACKAGE = "meanvalue_deform"
INSIDE_BLENDER = "bpy" in sys.modules

collect_ignore = [] if INSIDE_BLENDER else ["unit", "scenarios"]


def pytest_report_header():
    if not INSIDE_BLENDER:
        return "no bpy: unit/ and scenarios/ are left out, see run.py"
    import bpy

    return f"Blender {bpy.app.version_string}, add-on {os.environ.get('MEANVALUE_ADDON_ZIP')}"


@pytest.fixture(scope="session")
def installed_addon():
    """Installs the zip by Blender's own operator into a user folder of its own, where no copy of it was before."""
    import bpy

    zip_path = os.environ.get("MEANVALUE_ADDON_ZIP")
    advice = "set MEANVALUE_ADDON_ZIP to the add-on zip (./dev package makes it)"
    assert zip_path and pathlib.Path(zip_path).is_file(), advice
    wanted = os.environ.get("BLENDER_USER_SCRIPTS")
    assert wanted, "set BLENDER_USER_SCRIPTS to a folder of its own: tests must not touch the user's Blender"
    user_scripts = pathlib.Path(bpy.utils.user_resource('SCRIPTS')).resolve()
    assert user_scripts == pathlib.Path(wanted).resolve()

    addons = user_scripts / "addons"
    shutil.rmtree(addons / PACKAGE, ignore_errors=True)
    left = [path.name for path in addons.glob("*") if path.name != "__pycache__"]
    assert left == [], f"{addons} is not clean"
    assert PACKAGE not in sys.modules

    bpy.ops.preferences.addon_install(filepath=zip_path)
    enable()
    assert pathlib.Path(sys.modules[PACKAGE].__file__).resolve().parent == addons / PACKAGE
    return PACKAGE


def enable():
    import bpy

    assert bpy.ops.preferences.addon_enable(module=PACKAGE) == {'FINISHED'}


@pytest.fixture(autouse=True)
def empty_file(request):
    """Every test starts with factory settings, an empty file and the add-on enabled."""
    if not INSIDE_BLENDER:
        return
    import bpy

    request.getfixturevalue("installed_addon")
    bpy.ops.wm.read_factory_settings(use_empty=True)  # this disables all add-ons
    enable()
    addon("session").clear()


def addon(name):
    """A module of the installed add-on."""
    return importlib.import_module(f"{PACKAGE}.{name}")


@pytest.fixture
def part():
    """part("session") is that module of the installed add-on."""
    return addon


@pytest.fixture
def native():
    """The compiled module that the installed add-on uses."""
    return addon("native_loader").module()
