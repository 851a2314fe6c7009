# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/addon.md is what the registered add-on declares."""

import pathlib
import sys

import bpy
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging" / "site"))

import addon_page  # noqa: E402

PAGE = ROOT / "docs" / "reference" / "addon.md"


@pytest.mark.skipif(bpy.app.version >= (3, 5), reason="the page is written by Debian's Blender 3.4")
def test_the_page_is_what_the_addon_declares(part):
    page = addon_page.page(part("registration").CLASSES)
    assert page == PAGE.read_text(), "./dev docs reference writes it anew"


def test_everything_that_an_artist_sees_is_described(part):
    """Tooltips, all of them."""
    for cls in part("registration").CLASSES:
        if issubclass(cls, bpy.types.Operator):
            rna = getattr(bpy.ops.meanvalue, cls.bl_idname.partition(".")[2]).get_rna_type()
            assert rna.description, cls.bl_idname
            for each in addon_page.listed(rna.properties):
                assert each.description or each.is_hidden, f"{cls.bl_idname}, {each.identifier}"
