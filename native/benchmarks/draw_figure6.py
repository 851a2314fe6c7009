# SPDX-License-Identifier: MPL-2.0
"""Run by Blender after bench_table1: the paper's Figure 6, the original and every method with a close-up of the anchor.

Arguments: the .npz of bench_table1.save_shapes, and the PNG to write.
"""

import pathlib
import sys
import tempfile
import traceback

import bpy
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from mathutils import Matrix

from blender_tests.demo import markers, pictures, scene_mesh, stage

COLUMNS = 4
PICTURE = stage.Picture(width=480, height=330, samples=16)
AZIMUTH_DEG, ELEVATION_DEG = 48.0, 24.0
CLOSE_UP = 0.035  # half the side of the cube that the close-up shows, over the diagonal
MARKER_RADIUS = 0.0025  # over the diagonal
SKIN = (0.30, 0.42, 0.52)
LABEL_SIZE, LABEL_LEFT, LABEL_TOP = 0.065, 0.03, 0.09  # over the frame's width
GAP = 6  # pixels


def main(shapes_path, output):
    """Renders every panel twice and writes one picture."""
    data = np.load(shapes_path)
    rest, roi = upright(data["rest"]), data["roi"]
    shapes = {"original": rest}
    for method, vertices, energy in zip(data["methods"], data["shapes"], data["energies"], strict=True):
        shapes[f"{method}, G {energy:.1e}"] = upright(vertices)
    diagonal = float(np.linalg.norm(np.ptp(rest, axis=0)))
    everything = np.concatenate([vertices[roi] for vertices in shapes.values()])
    panels = []
    for label, vertices in shapes.items():
        panels.append(panel(label, vertices, data, everything, diagonal))
        print(f"drawn: {label}", flush=True)
    pictures.write_png(output, grid(panels))


def upright(vertices):
    """The dolphin's y is up; Blender's up is z."""
    return vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]


def panel(label, vertices, data, everything, diagonal):
    """The region of one shape above, its anchor's surroundings below: pixels."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    obj = scene_mesh.new_object("Shape", vertices, data["faces"])
    scene_mesh.shade_smooth(obj)
    obj.data.materials.append(scene_mesh.plain_material("Skin", SKIN, 0.45))
    border = vertices[markers.border_vertices(obj, data["roi"])]
    markers.add_spheres("Border", border, MARKER_RADIUS * diagonal, markers.BORDER_COLOUR)
    anchor = vertices[data["anchors"]]
    markers.add_spheres("Anchor", anchor, MARKER_RADIUS * diagonal, markers.ANCHOR_COLOUR)
    stage.set_stage(np.concatenate([vertices, everything]), PICTURE, AZIMUTH_DEG, ELEVATION_DEG)
    bpy.data.objects.remove(bpy.data.objects["Ground"])  # the fins' shadow would only distract
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    close = shot(anchor[0] + CLOSE_UP * diagonal * corners, None)
    return np.concatenate([close, np.ones((GAP, PICTURE.width, 4), np.float32), shot(everything, label)])


def shot(points, label):
    """A render that shows `points`, with a label where there is one: pixels."""
    axes = stage.camera_axes(AZIMUTH_DEG, ELEVATION_DEG)
    position = stage.fitted_camera_position(points, axes, PICTURE.width / PICTURE.height, 0.04)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = axes.T, position
    bpy.context.scene.camera.matrix_world = Matrix(matrix.tolist())
    if label:
        add_label(label, matrix)
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "panel.png"
        stage.render(path)
        return pictures.over_backdrop(pictures.read_png(path))


def add_label(text, camera_matrix):
    """Writes `text` in the frame's upper left corner, close before the camera."""
    curve = bpy.data.curves.new("Label", "FONT")
    depth = 2.0 * bpy.context.scene.camera.data.clip_start
    width = depth * stage.SENSOR_MM / stage.LENS_MM
    curve.body, curve.size = text, LABEL_SIZE * width
    obj = bpy.data.objects.new("Label", curve)
    height = width * PICTURE.height / PICTURE.width
    place = np.eye(4)
    place[:3, 3] = [(LABEL_LEFT - 0.5) * width, 0.5 * height - LABEL_TOP * width, -depth]
    obj.matrix_world = Matrix((camera_matrix @ place).tolist())
    obj.data.materials.append(ink())
    bpy.context.scene.collection.objects.link(obj)


def ink():
    """A black that no light changes."""
    material = bpy.data.materials.new("Ink")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    material.node_tree.links.new(emission.outputs["Emission"], nodes["Material Output"].inputs["Surface"])
    return material


def grid(panels):
    """The panels in rows of COLUMNS, bottom row first as Blender has it."""
    blank = np.ones_like(panels[0])
    rows = []
    for first in range(0, len(panels), COLUMNS):
        row = panels[first : first + COLUMNS]
        row += [blank] * (COLUMNS - len(row))
        joined = row[0]
        for right in row[1:]:
            joined = pictures.side_by_side(joined, right, GAP)
        rows.insert(0, joined)
        rows.insert(0, np.ones((3 * GAP, joined.shape[1], 4), np.float32))
    return np.concatenate(rows[1:])


if __name__ == "__main__":
    try:
        main(*map(pathlib.Path, sys.argv[sys.argv.index("--") + 1 :]))
    except Exception:  # Blender would go on, and end with its own status
        traceback.print_exc()
        sys.stderr.flush()
        sys.exit(1)
