# SPDX-License-Identifier: GPL-3.0-or-later
"""A newer version installed over one that is on and has been used."""

import re
import zipfile

import bpy
import pytest
from support import installed, meshes, steps

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
    before = len([name for name in dir(bpy.types) if name.startswith("MEANVALUE_")])
    _install_over(newer)
    assert bpy.types.MEANVALUE_PT_bake.MARK == NEWER
    assert len([name for name in dir(bpy.types) if name.startswith("MEANVALUE_")]) == before
    assert obj.meanvalue.bound.is_bound
    steps.solve()
