# SPDX-License-Identifier: GPL-3.0-or-later
"""Copy System Info: all that a report should say, and nothing of what the artist's things are called."""

import bpy
import pytest
from support import meshes, steps

SECRET = "Zarquon"


def told(part):
    facts = part("posing.operators.system_facts")
    subject = part("scene.subject").of(bpy.context)
    return part("posing.core.system_info").text(facts.sections(subject))


def test_a_posed_object_without_a_name_of_the_artists(part, native, tmp_path):
    obj = steps.posed_grid(meshes.grid())
    obj.name = f"{SECRET} body"
    obj.vertex_groups["Tip"].name = f"{SECRET} tip"
    obj.meanvalue.handles["Tip"].name = f"{SECRET} tip"
    obj.modifiers.new(SECRET, 'SUBSURF')
    obj.modifiers.new(SECRET, 'SUBSURF')
    obj.modifiers.new(SECRET, 'SMOOTH').show_viewport = False
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{SECRET}.blend"))
    steps.solve()
    region = steps.add_group(obj, f"{SECRET} region", range(10, 25))
    obj.meanvalue.roi_group = region.name
    text = told(part)
    assert SECRET not in text and str(tmp_path) not in text
    for line in (
        f"Blender: {bpy.app.version_string}",
        "Vertices: 25",
        "Faces: 16",
        "Modifiers: SMOOTH, SUBSURF 2",
        "Shape keys: 3",
        "Pins: 2",
        "Region: 15 vertices, 0 of them with a falloff",
        "Method: fast",
        "Last message: Solved into 'Mean-Value'",
    ):
        assert line in text or line.replace("'Mean-Value'", "'...'") in text, line
    info = native.build_info()
    assert f"Solver: {native.__version__}, {info['compiler']}" in text
    assert "Bound: 25 vertices, 4 held" in text and "Solved: " in text


def test_the_last_refusal_is_told(part):
    obj = meshes.grid()
    obj.name = SECRET
    steps.add_group(obj, "Other", [0])
    with pytest.raises(RuntimeError):
        bpy.ops.meanvalue.add_handle(pin=True, group="Nowhere")
    text = told(part)
    assert "Last message: '...' has no vertex group '...'" in text and SECRET not in text


@pytest.mark.parametrize("kind", ["nothing", "camera", "edit mode"])
def test_it_works_wherever_one_is(part, kind, capfd):
    if kind == "camera":
        bpy.ops.object.camera_add()
    elif kind == "edit mode":
        obj = meshes.grid()
        obj.meanvalue.roi_group = steps.add_group(obj, "Soft", [1, 2]).name
        bpy.ops.object.mode_set(mode='EDIT')
    assert bpy.ops.meanvalue.copy_system_info() == {'FINISHED'}
    text = told(part)
    wanted = {"nothing": "Type: none", "camera": "Type: CAMERA", "edit mode": "Region: not read in Edit Mode"}[kind]
    assert wanted in text
    if bpy.app.background:
        assert wanted in capfd.readouterr().out
    else:
        assert bpy.context.window_manager.clipboard.startswith("Mean-Value Deform ")
