# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy System Info: all that a report should say, and nothing of what the artist's things are called."""

import bpy
import pytest
from support import meshes, steps

SECRET = "Zarquon"


def told(capfd):
    assert bpy.ops.meanvalue.copy_system_info() == {'FINISHED'}
    return capfd.readouterr().out if bpy.app.background else bpy.context.window_manager.clipboard


def test_a_posed_object_without_a_name_of_the_artists(native, tmp_path, capfd):
    obj = steps.posed_grid(meshes.grid())
    obj.name = f"{SECRET} body"
    obj.vertex_groups["Tip"].name = f"{SECRET} tip"
    obj.meanvalue.handles["Tip"].name = f"{SECRET} tip"
    obj.modifiers.new(SECRET, 'SUBSURF')
    steps.solve()
    obj.meanvalue.roi_group = steps.add_group(obj, f"{SECRET} region", range(10, 25)).name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{SECRET}.blend"))
    capfd.readouterr()
    text = told(capfd)
    assert SECRET not in text and str(tmp_path) not in text
    for line in (f"Blender: {bpy.app.version_string}", "Vertices, edges, faces: 25, 40, 16", "Modifiers: SUBSURF",
                 "Handles and pins, region: 2, True", "Method: fast", f"Solver: {native.__version__}"):  # fmt: skip
        assert line in text, line


@pytest.mark.parametrize("kind", ["none", "CAMERA", "MESH"])
def test_it_works_wherever_one_is(kind, capfd):
    if kind == "CAMERA":
        bpy.ops.object.camera_add()
    elif kind == "MESH":
        meshes.grid()
        bpy.ops.object.mode_set(mode='EDIT')
    assert f"Active object: {kind}" in told(capfd)
