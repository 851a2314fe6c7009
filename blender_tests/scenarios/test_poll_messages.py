# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot work is greyed and says why: no operator that is available opens an error on a mesh with nothing made."""

import bpy
import pytest
from support import libraries, meshes

#: By the tool, after a file was chosen, or with another mesh that may be given: its buttons are greyed one by one.
ELSEWHERE = {"import_motion", "grab", "morph"}


def names():
    found = [name for name in dir(bpy.types) if name.startswith("MEANVALUE_OT_")]
    return sorted({name.removeprefix("MEANVALUE_OT_") for name in found} - ELSEWHERE)


def fresh():
    meshes.tube()


def in_edit_mode():
    meshes.tube()
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='DESELECT')


def linked(tmp_path):
    obj = meshes.tube()
    obj.data = libraries.linked(tmp_path, obj.data, "meshes")


@pytest.mark.parametrize("kind", ["fresh", "edit", "linked"])
def test_refused_with_a_reason_or_without_an_error(kind, tmp_path):
    wrong = []
    for name in names():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
        {"fresh": fresh, "edit": in_edit_mode, "linked": lambda: linked(tmp_path)}[kind]()
        operator = getattr(bpy.ops.meanvalue, name)
        try:
            operator()
        except RuntimeError as error:
            refusal = f"bpy.ops.meanvalue.{name}.poll() "
            if refusal not in str(error) or "context is incorrect" in str(error):
                wrong.append((name, str(error)))
    assert wrong == []
