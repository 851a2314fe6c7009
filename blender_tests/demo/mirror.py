# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo mirror`, and its report."""

import bmesh
import bpy
import numpy as np
from mathutils import Matrix, Vector
from support import figure_body, steps, walking_figure

from . import pose, report, scene_mesh, stage
from .example.run import draw_shapes
from .rig.run import BODY_COLOUR

SPACING = 0.0125  # metres between vertices
RAISED_DEG = 50.0
#: What is below is pinned, of the height.
FEET = 0.05
ABOUT = (
    "half a figure below a Mirror modifier",
    "The seam is to stay in the mirror plane. Alone, the half has a free border there.",
)
DESCRIPTION = """\
Half a figure raises its arm, by the add-on's operators, as if it were all there is and below a Mirror modifier. A
picture of it at rest and of both poses, all with the modifier on, the .blend file and a report."""
OPTIONS = {}


def blocks(words, empty_scene):
    """The report's lines; makes the files."""
    empty_scene()
    obj, shoulder = half_figure()
    rest = pose.positions(obj)
    raise_hand(obj, shoulder)
    alone, whole = both_poses(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / "mirror_seam.blend"), check_existing=False)
    path = words.output / "mirror_seam.png"
    seen = np.concatenate([shape * (side, 1.0, 1.0) for shape in (rest, alone, whole) for side in (1.0, -1.0)])
    draw_shapes(path, obj, (rest, alone, whole), stage.Picture(640, 720, words.samples, words.engine), seen)
    seam = np.abs(rest[:, 0]) < 1e-6
    rows = [
        ("vertices, of the seam", f"{len(rest):,}, {seam.sum()}"),
        ("seam off the plane", f"{np.abs(alone[seam, 0]).max():.4f} m alone, {np.abs(whole[seam, 0]).max():.1e} m"),
        ("files", f"{path.name}, mirror_seam.blend"),
    ]
    return [report.block("the walking figure's left half", rows)]


def half_figure(spacing=SPACING):
    """(mesh object, shoulder (3,)): the walking figure's left half, cut in the plane X = 0."""
    body = figure_body.body(spacing=spacing)
    joints, _ = walking_figure.upright(1, body.legs)
    obj = scene_mesh.new_object("Half", body.vertices, body.quads)
    cut = bmesh.new()
    cut.from_mesh(obj.data)
    geometry = [*cut.verts, *cut.edges, *cut.faces]
    bmesh.ops.bisect_plane(cut, geom=geometry, dist=1e-4, plane_co=(0, 0, 0), plane_no=(-1, 0, 0), clear_outer=True)
    for vertex in cut.verts:
        if abs(vertex.co.x) < 1e-4:
            vertex.co.x = 0.0
    cut.to_mesh(obj.data)
    cut.free()
    scene_mesh.shade_smooth(obj)
    obj.data.materials.append(scene_mesh.plain_material("Skin", BODY_COLOUR, 0.45))
    bpy.context.view_layer.objects.active = obj
    return obj, joints["shoulder.L"][0]


def raise_hand(obj, shoulder):
    """Pins the foot, and turns a handle at the hand about the shoulder."""
    rest = pose.positions(obj)
    height, reach = np.ptp(rest[:, 2]), rest[:, 0].max()
    members = {"Foot": rest[:, 2] < rest[:, 2].min() + FEET * height, "Hand": rest[:, 0] > 0.85 * reach}
    for name, is_member in members.items():
        steps.add_group(obj, name, np.flatnonzero(is_member))
        bpy.context.view_layer.objects.active = obj
        pose.call(bpy.ops.meanvalue.add_handle, group=name, pin=name == "Foot", live=False)
    obj.meanvalue.live = False
    bpy.context.view_layer.update()
    control, centre = obj.meanvalue.handles["Hand"].control, Matrix.Translation(Vector(shoulder))
    turn = centre @ Matrix.Rotation(np.radians(-RAISED_DEG), 4, 'Y') @ centre.inverted()
    control.matrix_world = turn @ control.matrix_world
    bpy.context.view_layer.update()


def both_poses(obj):
    """[(n, 3), (n, 3)]: the half as it is posed alone, and below a Mirror modifier, which it has from then on."""
    alone = solved(obj)
    obj.modifiers.new("Mirror", 'MIRROR').use_clip = True
    return [alone, solved(obj)]


def solved(obj):
    """(n, 3): the half as it is posed now."""
    bpy.context.view_layer.objects.active = obj
    pose.call(bpy.ops.meanvalue.solve)
    return pose.positions(obj, pose.result_key(obj))
