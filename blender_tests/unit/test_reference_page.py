# SPDX-License-Identifier: GPL-3.0-or-later
"""What docs/reference/addon.md takes from the registered add-on."""

import pathlib
import sys

import bpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "packaging" / "site"))

import addon_page  # noqa: E402


def test_everything_that_an_artist_sees_is_described(part):
    """Tooltips, all of them."""
    for cls in part("registration").CLASSES:
        if issubclass(cls, bpy.types.Operator):
            rna = getattr(bpy.ops.meanvalue, cls.bl_idname.partition(".")[2]).get_rna_type()
            assert rna.description, cls.bl_idname
            for each in addon_page.listed(rna.properties):
                assert each.description or each.is_hidden, f"{cls.bl_idname}, {each.identifier}"
