# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo character`, and its report."""

import bmesh
import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from support import meshes, steps

from . import markers, pictures, pose, ready, report, scene_mesh, stage
from .rig import figures
from .rig.run import add_body, turn

ABOUT = ("a clothed figure on a rig, posed by Grab: what it wears goes along, in objects of its own",)
DESCRIPTION = """\
A generated figure with shirt, trousers, shoes, hat, hair, eyes, buttons and a bag is posed on its rig by the add-on's
operators. A picture of it before and after, the .blend file and a report."""
OPTIONS = {}

#: Garments: which of the body's skin they cover (from where to where along an axis), how far above it, color.
UP, ACROSS, OUT = np.array(((0.0, 0.0, 1.0), (0.865, 0.0, 0.502), (1.0, 0.0, 0.0)))
GARMENTS = {
    "Trousers": (UP, 0.095, 1.02, 0.006, (0.05, 0.09, 0.22)),
    "Shirt": (UP, 0.93, 1.535, 0.018, (0.55, 0.06, 0.04)),
    "Strap": (ACROSS, 0.61, 0.65, 0.029, (0.12, 0.06, 0.03)),
    "Shoes": (UP, -1.0, 0.115, 0.01, (0.08, 0.045, 0.03)),
    "Hat": (UP, 1.715, 2.0, 0.02, (0.75, 0.45, 0.06)),
    "Hat Band": (UP, 1.71, 1.745, 0.028, (0.60, 0.33, 0.04)),
}
WRIST, THICK, SLIVER = 0.67, 0.006, 0.004
#: Balls: their bone, which places of the skin they are at (x, z from the front), how far off these, radius, color.
EYES = [(-0.028, 1.685), (0.028, 1.685)]
BALLS = {
    "Eyes": ("head", EYES, (0.0, 0.003, 0.0), 0.017, (0.9, 0.9, 0.88)),
    "Pupils": ("head", EYES, (0.0, -0.009, 0.0), 0.0085, (0.02, 0.015, 0.01)),
    "Pompom": ("head", [(0.0, 1.75)], (0.0, 0.085, 0.08), 0.042, (0.8, 0.8, 0.75)),
    "Buttons": ("chest", [(0.0, z) for z in np.arange(1.04, 1.47, 0.14)], (0.0, -0.025, 0.0), 0.011, (0.9, 0.8, 0.55)),
}
#: Hair and bag: colors; strips, points of each; places of the corners, and their faces.
HAIR, LEATHER, STRIPS, POINTS = (0.10, 0.04, 0.015), (0.20, 0.10, 0.045), 26, 7
CORNERS = (0.215, 0.0, 0.91) + (np.indices((2, 2, 2)).reshape(3, 8).T - 0.5) * (0.08, 0.2, 0.15)
SIDES = (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)
#: How far arms hang, in degrees. What is grabbed, and how far it is dragged, in metres: places are those of the T-pose.
HANG = 40.0
DRAGS = (
    ((0.82, 0.0, 1.44), (-0.22, -0.1, 0.72)),
    ((-0.09, -0.1, 0.05), (-0.2, -0.2, 0.16)),
    ((-0.82, 0.0, 1.44), (0.05, -0.2, 0.12)),
    ((0.0, 0.0, 1.79), (0.07, 0.0, -0.02)),
)


def blocks(words, empty_scene):
    """The report's lines; makes the files."""
    empty_scene()
    body, worn = dressed(figures.walker())
    seen = [meshes.seen(body)]
    drag(body)
    size, path = stage.Picture(560, 800, words.samples, words.engine), words.output / "character.png"
    stage.set_stage(np.concatenate([*seen, meshes.seen(body)]), size, 20.0, 6.0, margin=0.05)
    body.meanvalue.live, shots = False, []
    for pose.result_key(body).value in (0.0, 1.0):
        bpy.context.view_layer.update()
        shots.append(stage.render(path))
    pictures.write_png(path, pictures.side_by_side(shots))
    body.meanvalue.live = True
    ready.look_through_camera()
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / "character.blend"), check_existing=False)
    below, skin, cloth = measured(body, worn)
    rows = [
        ("what is worn", f"{len(worn)} objects; {below:.2%} of it goes below the skin"),
        ("edges grow", f"99 % of the body's to at most {skin:.2f}, of what is worn to {cloth:.2f}"),
        ("files", f"{path.name}, character.blend"),
    ]
    return [report.block("a clothed figure", rows)]


def dressed(figure):
    """(body, [what it wears]) with arms that hang."""
    body, armature = add_body(figure)
    worn, hung = [garment(body, name, *how) for name, how in GARMENTS.items()], []
    for name, (bone, places, offset, radius, color) in BALLS.items():
        centres = [np.array(body.ray_cast((x, -1.0, z), (0.0, 1.0, 0.0))[1]) + offset for x, z in places]
        hung.append((bone, markers.add_spheres(name, np.array(centres), radius, color)))
    for name, bone, shape, color in (("Hair", "head", hair(), HAIR), ("Bag", "pelvis", (CORNERS, SIDES), LEATHER)):
        hung.append((bone, scene_mesh.new_object(name, *shape)))
        hung[-1][1].data.materials.append(scene_mesh.plain_material(name, color, 0.5))
    bpy.data.objects["Bag"].modifiers.new("Bevel", 'BEVEL').width = 0.02
    for bone, obj in hung:
        steps.add_weights(obj, bone, np.ones(len(obj.data.vertices)))
        obj.modifiers.new("Armature", 'ARMATURE').object = armature
    for side, degrees in (("L", HANG), ("R", -HANG)):
        turn(armature, f"upper_arm.{side}", (0.0, 1.0, 0.0), degrees)
    return body, [*worn, *(obj for _bone, obj in hung)]


def garment(body, name, axis, low, high, above, color):
    """A part of the body's skin, moved out, with its weights."""
    obj, cut = meshes.duplicate(body, name=name), bmesh.new()
    cut.from_mesh(obj.data)
    for along, limit in ((axis, high), (-axis, -low), (OUT, WRIST), (-OUT, WRIST)):
        everything, at = [*cut.verts, *cut.edges, *cut.faces], limit * along
        bmesh.ops.bisect_plane(cut, geom=everything, dist=1e-4, plane_co=at, plane_no=along, clear_outer=True)
    bmesh.ops.remove_doubles(cut, verts=cut.verts[:], dist=SLIVER)
    cut.normal_update()
    for vertex in cut.verts:
        vertex.co += above * vertex.normal
    cut.to_mesh(obj.data)
    cut.free()
    solid = obj.modifiers.new("Solidify", 'SOLIDIFY')
    solid.thickness, solid.offset = THICK, 1.0
    obj.data.materials[0] = scene_mesh.plain_material(name, color, 0.8)
    return obj


def hair():
    """(vertices, faces): strips that hang around the head, but for the face."""
    angle = np.radians(np.linspace(-25.0, 205.0, STRIPS))[:, None, None]
    down, sides = np.linspace(0.0, 1.0, POINTS)[:, None], angle + np.array((-0.1, 0.1))
    out = 1.08 + 0.25 * np.sqrt(down) + 0.03 * np.cos(9.0 * angle)
    places = 0.07 * out * np.cos(sides), 0.012 + 0.096 * out * np.sin(sides), 1.73 - 0.185 * down + 0.0 * sides
    faces = np.array(meshes.grid_faces(2, POINTS)) + 2 * POINTS * np.arange(STRIPS)[:, None, None]
    return np.stack(places, axis=-1).reshape(-1, 3), faces.reshape(-1, 4)


def drag(body):
    """Presses on the body, and drags."""
    for place, offset in DRAGS:
        vertex = np.linalg.norm(pose.positions(body) - place, axis=1).argmin()
        pose.call(bpy.ops.meanvalue.grab, object_name=body.name, vertex=int(vertex), offset=offset)
        bpy.context.view_layer.update()


def measured(body, worn):
    """(share of what is worn that went below the skin, what 99 % of the body's edges grew to at most, that of worn)"""
    shapes = [[pose.positions(obj, key) for key in (None, pose.result_key(obj))] for obj in (body, *worn)]
    growth, below = [], []
    for obj, both in zip((body, *worn), shapes, strict=True):
        rest, posed = (np.linalg.norm(np.diff(shape[scene_mesh.edges(obj)], axis=1), axis=2) for shape in both)
        growth.append((posed / rest).ravel())
    for skin, *others in zip(*shapes, strict=True):
        tree = BVHTree.FromPolygons(skin, [face.vertices for face in body.data.polygons])
        found = [(place, *tree.find_nearest(place)[:2]) for place in np.concatenate(others)]
        below.append(np.array([(place - near) @ normal < 0.0 for place, near, normal in found]))
    most = [np.quantile(each, 0.99) for each in (growth[0], np.concatenate(growth[1:]))]
    return (below[1] & ~below[0]).mean(), *most
