# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests inside Blender start from: the installed add-on, enabled, in an empty file.

Tests in host/ need no Blender and none of this.
"""

import os
import pathlib
import sys

import pytest
from support import installed

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
INSIDE_BLENDER = "bpy" in sys.modules

collect_ignore = [] if INSIDE_BLENDER else ["unit", "scenarios"]


def pytest_report_header():
    if not INSIDE_BLENDER:
        return "no bpy: unit/ and scenarios/ are left out, see run.py"
    import bpy

    return f"Blender {bpy.app.version_string}, {installed.PACKAGE} of {installed.ZIP}"


@pytest.fixture(scope="session")
def installed_addon():
    """Installs the zip into a user folder of its own, where no copy of it was before."""
    import bpy

    advice = "set MEANVALUE_ADDON_ZIP to the add-on zip (./dev package makes it)"
    assert installed.ZIP and pathlib.Path(installed.ZIP).is_file(), advice
    wanted = os.environ.get("BLENDER_USER_SCRIPTS")
    assert wanted, "set BLENDER_USER_SCRIPTS to a folder of its own: tests must not touch the user's Blender"
    user_scripts = pathlib.Path(bpy.utils.user_resource('SCRIPTS')).resolve()
    assert user_scripts == pathlib.Path(wanted).resolve()
    installed.install()
    return installed.PACKAGE


@pytest.fixture(autouse=True)
def empty_file(request):
    """Every test starts with factory settings, an empty file and the add-on enabled.

    None leaves a scene in bpy.context, as reading `context.tool_settings` or `context.layer_collection` does in 3.4:
    once that scene is freed, as by loading a file, setting `context.window.scene`, as importers do, writes to it.
    """
    if INSIDE_BLENDER:
        import bpy

        request.getfixturevalue("installed_addon")
        bpy.ops.wm.read_factory_settings(use_empty=True)  # this disables all add-ons
        installed.enable()
        installed.part("solver.session").cache.clear()
    yield
    if INSIDE_BLENDER:
        assert bpy.context.id_data is None, "something read context.tool_settings or context.layer_collection"


@pytest.fixture
def part():
    """part("solver.session") is that module of the installed add-on."""
    return installed.part


@pytest.fixture
def native():
    """The compiled module that the installed add-on uses."""
    return installed.part("solver.native_loader").module()


@pytest.fixture
def status(part):
    """status(obj): (what the panel says of live posing, whether it is a problem)."""
    return lambda obj: part("live.engine").status(obj) or ("", False)


@pytest.fixture
def saved(tmp_path):
    """(object, control, path of its cache) of an animated tube in a saved file."""
    from support import baking

    return baking.saved_tube(tmp_path)
