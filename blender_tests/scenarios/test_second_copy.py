# SPDX-License-Identifier: GPL-3.0-or-later
"""The same add-on installed twice, as an extension beside a legacy copy."""

import pathlib
import shutil
import sys

import bpy
import pytest
from support import installed, meshes, steps

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


def registered():
    return {name: getattr(bpy.types, name).__module__ for name in dir(bpy.types) if name.startswith("MEANVALUE_")}


def test_the_second_copy_is_refused_and_leaves_the_first(second):
    before = registered()
    with pytest.raises(RuntimeError, match=rf"Another copy of Mean-Value Deform is on \({FIRST}\)"):
        bpy.ops.preferences.addon_enable(module=second)
    assert bpy.ops.preferences.addon_disable(module=second) == {'FINISHED'}
    assert registered() == before
    steps.posed_grid(meshes.grid())
    steps.solve()


def test_turning_the_first_off_and_the_second_on(second):
    assert bpy.ops.preferences.addon_disable(module=FIRST) == {'FINISHED'}
    bpy.ops.preferences.addon_enable(module=second)
    assert all(module.startswith(f"{second}.") for module in registered().values())
    steps.posed_grid(meshes.grid())
    steps.solve()
    bpy.ops.preferences.addon_disable(module=second)
    assert registered() == {}
    assert bpy.ops.preferences.addon_enable(module=FIRST) == {'FINISHED'}
