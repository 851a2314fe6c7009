# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion capture in the panel: import, match with lines, a point picked by a click. The pictures are for looking at.

    ./dev test --only ui -k motion_capture
"""

import pathlib
import tempfile

import bpy
import numpy as np
from harness import tabs, view
from support import body_mesh, handles, meshes, take_files, walking_figure

RINGS, SEGMENTS = 25, 24
MARKED = [ring * SEGMENTS + segment for ring in range(2, RINGS, 5) for segment in range(0, SEGMENTS, 6)]
LABELS = tuple(f"RING{vertex // SEGMENTS}_{vertex % SEGMENTS}" for vertex in MARKED)
#: The walking figure's 41 markers, a cuff around each thigh and shank, and two of each foot.
WITH_CUFFS = 49


def _take_file():
    """A TRC file of markers on the tube, which bends and has a gap and a jump."""
    rest = np.array([vertex.co for vertex in handles.again().data.vertices])[MARKED]
    outwards = rest * (1.0, 1.0, 0.0)
    markers = rest + 0.25 * outwards * np.linspace(0.2, 1.0, len(MARKED))[:, None]
    angles = 0.6 * np.sin(np.arange(150) / 24.0)[:, None] * markers[:, 2] / rest[:, 2].max()
    positions = np.repeat(markers[None], 150, axis=0)
    positions[..., 0] = markers[:, 0] * np.cos(angles) + markers[:, 2] * np.sin(angles)
    positions[..., 2] = markers[:, 2] * np.cos(angles) - markers[:, 0] * np.sin(angles)
    positions[20:145, 3] = np.nan
    positions[70:, 9] += (0.0, 2.0, 0.0)
    return take_files.write_trc(pathlib.Path(tempfile.mkdtemp()) / "bend.trc", LABELS, positions)


def import_match_and_pick(ui):
    meshes.tube(RINGS, SEGMENTS, "Tube")
    ui.frame_all()
    yield from tabs.open_part(ui, "capture")
    handles.again().meanvalue.capture.align = 'NONE'
    ui.remember()
    yield from ui.screenshot("capture_01_before")

    # By Python, as a file browser cannot be told a path here.
    with view.override():
        given = {"filepath": _take_file(), "up_axis": 'Z', "unit": 'METRES'}  # no person is so tall
        assert bpy.ops.meanvalue.import_motion('EXEC_DEFAULT', True, **given) == {'FINISHED'}
    assert bpy.context.object == handles.again() and len(handles.again().meanvalue.capture.pairs) == len(MARKED)
    yield from ui.screenshot("capture_02_imported")

    yield from ui.invoke("meanvalue.find_marker_problems")
    assert len(bpy.data.collections["bend"].meanvalue.problems) >= 2
    yield from ui.screenshot("capture_03_problems")

    handles.again().meanvalue.capture.reference_frame = 1.0
    yield from ui.invoke("meanvalue.match_markers")
    yield from ui.wait_until(lambda: any("20 markers matched" in line for line in ui.reports()), "they are matched")
    assert len(handles.again().meanvalue.handles) == len(MARKED)
    yield from ui.screenshot("capture_04_matched")

    yield from _pick(ui)

    for _ in range(2):
        yield from ui.undo()
    assert len(handles.again().meanvalue.handles) == 0
    yield from ui.screenshot("capture_06_undone")


def _pick(ui):
    """The point of the first marker in front, by a click at a vertex beside it."""
    capture = handles.again().meanvalue.capture
    bpy.context.scene.frame_set(1)
    to_view, vertices = view.area().spaces.active.region_3d.view_matrix, handles.again().data.vertices
    front = min(range(len(MARKED)), key=lambda number: (to_view @ vertices[MARKED[number]].co).length)
    capture.active_pair = front
    name, before = capture.pairs[front].name, capture.pairs[front].vertex
    goal = before + SEGMENTS
    yield from ui.invoke("meanvalue.pick_marker_point")
    assert name in ui.status_text(), ui.status_text()
    yield from ui.click(*ui.project(handles.again().matrix_world @ handles.again().data.vertices[goal].co))
    pair = handles.again().meanvalue.capture.pairs[name]
    assert (pair.vertex, pair.is_picked) == (goal, True), (before, goal, pair.vertex)
    assert ui.status_text() is None
    yield from ui.screenshot("capture_05_picked")

    yield from ui.invoke("meanvalue.pick_marker_point")
    yield from ui.key('ESC')
    assert ui.status_text() is None
    assert handles.again().meanvalue.capture.pairs[name].vertex == goal


def a_body_in_the_walk(ui):
    """Aligned by itself, matched with progress, and followed."""
    vertices, triangles, _bones = body_mesh.body()
    body = meshes.make_object(vertices.tolist(), triangles.tolist(), "Body")
    folder = pathlib.Path(tempfile.mkdtemp())
    for name, figure in (("walk", walking_figure.take(frames=200)), ("standing", walking_figure.t_pose(frames=5))):
        path = take_files.write_trc(folder / f"{name}.trc", figure.labels, figure.positions, figure.rate_hz)
        with view.override():
            bpy.ops.meanvalue.import_motion('EXEC_DEFAULT', True, filepath=path, up_axis='Z')
    body.meanvalue.capture.reference_take = bpy.data.collections["standing"]
    meshes.activate(body)
    for collection in ("walk", "standing"):
        bpy.context.view_layer.layer_collection.children[collection].hide_viewport = True
    ui.frame_all()
    yield from tabs.open_part(ui, "capture", "MEANVALUE_PT_capture")
    yield from ui.invoke("meanvalue.match_markers")
    yield from ui.wait_until(lambda: len(_handles_of_body()) == WITH_CUFFS, "all are matched")
    view.area().spaces.active.overlay.show_relationship_lines = False
    yield from ui.screenshot("capture_08_body")
    bpy.context.object.meanvalue.live = True
    bpy.context.scene.frame_set(20)
    yield from ui.pause(3.0)
    yield from ui.screenshot("capture_09_body_walks")
    yield from tabs.scroll_down(ui)
    height = -view.region('UI').view2d.region_to_view(0, 0)[1]
    assert 600.0 < height <= 800.0, f"the tab, with a note of how it follows, fits on a screen: {height}"
    yield from ui.invoke("meanvalue.match_markers")
    yield from ui.key('ESC')  # whether it is heard or comes too late
    yield from ui.wait_until(lambda: ui.status_text() is None, "matching is over")
    assert len(_handles_of_body()) == WITH_CUFFS


def _handles_of_body():
    return bpy.data.objects["Body"].meanvalue.handles
