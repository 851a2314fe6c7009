# SPDX-License-Identifier: GPL-3.0-or-later
"""A textured figure with bones as a game has it, written as glTF: every vertex is split where its texture is cut."""

import bpy
import numpy as np

from . import scene_mesh
from .rig import figures
from .rig import run as rig

SPACING = 0.022  # metres between vertices
TILE, TILES = 128, 4  # pixels of the square that a bone has in the texture, and squares of a row
MARGIN = 0.08  # of a square, free around what is in it

SKIN, HAIR, SHIRT, STRIPE, BELT, TROUSERS, CUFF, SHOE, SOLE, EYE = (
    np.array(colour) / 255.0
    for colour in (
        *((224, 172, 138), (84, 48, 26), (190, 52, 44), (240, 226, 196), (52, 38, 30)),
        *((62, 84, 134), (44, 60, 100), (70, 46, 34), (226, 220, 210), (30, 34, 48)),
    )
)


def write(path):
    """Writes the figure to the .glb file `path`; the scene is no good after that."""
    figure = figures.walker(SPACING)
    obj, armature = rig.add_body(figure)
    obj.name, obj.parent = "Game Figure", armature
    order = {name: number for number, name in enumerate(figure.bones)}
    weights = np.zeros((len(figure.vertices), len(order)))
    for name, (indices, values) in figure.weights.items():
        weights[indices, order[name]] = values
    quads = np.asarray(figure.polygons)
    bone_of_face = weights[quads].sum(axis=1).argmax(axis=1)
    layer = obj.data.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", texture_places(figure, quads, bone_of_face).astype(np.float32).ravel())
    obj.data.materials.clear()
    obj.data.materials.append(textured_material(painted(list(figure.bones))))
    for each in bpy.context.scene.objects:
        each.select_set(each in (obj, armature))
    bpy.ops.export_scene.gltf(filepath=str(path), export_format='GLB', use_selection=True)


def texture_places(figure, quads, bone_of_face):
    """(4 q, 2): where the corners of the quads are in the texture: around their bone, cut at its back, and along it."""
    result = np.zeros((len(quads), 4, 2))
    for number, (name, (head, tail, _parent)) in enumerate(figure.bones.items()):
        faces = np.flatnonzero(bone_of_face == number)
        axis = np.array((0.0, 0.0, 1.0)) if name == "head" else (tail - head) / np.linalg.norm(tail - head)
        front = np.array((0.0, -1.0, 0.0)) if abs(axis[1]) < 0.9 else np.array((0.0, 0.0, 1.0))
        front = front - (front @ axis) * axis
        away = figure.vertices[quads[faces]] - head
        angle = np.arctan2(away @ np.cross(axis, front), away @ front) / (2.0 * np.pi)
        middle = np.arctan2(*(away.mean(axis=1) @ each for each in (np.cross(axis, front), front))) / (2.0 * np.pi)
        around = middle[:, None] + (angle - middle[:, None] + 0.5) % 1.0 - 0.5
        for part, values in enumerate((around, away @ axis)):
            low, high = values.min(initial=1e9), values.max(initial=-1e9)
            inside = MARGIN + (1.0 - 2.0 * MARGIN) * (values - low) / max(high - low, 1e-9)
            result[faces, :, part] = (inside + (number % TILES, number // TILES)[part]) / TILES
    return result.reshape(-1, 2)


def painted(bones):
    """(TILES * TILE, TILES * TILE, 4): the texture, bottom row first, with a square for each of the bones."""
    picture = np.ones((TILES * TILE, TILES * TILE, 4))
    across, up = np.meshgrid((np.arange(TILE) + 0.5) / TILE, (np.arange(TILE) + 0.5) / TILE)
    across, up = ((each - MARGIN) / (1.0 - 2.0 * MARGIN) for each in (across, up))
    for number, name in enumerate(bones):
        row, column = divmod(number, TILES)
        square = picture[row * TILE : (row + 1) * TILE, column * TILE : (column + 1) * TILE, :3]
        square[:] = SKIN
        for colour, where in clothes(name.partition(".")[0], across, up):
            square[where] = colour
    return picture


def clothes(part, across, up):
    """Yields (colour, where) of a square, what is on top last; across: 0 to 1, the front at 0.5; up: along the bone."""
    stripes = (up * 6.0 % 1.0) < 0.35
    if part in ("chest", "upper_arm"):
        yield SHIRT, up < 2.0
        yield STRIPE, stripes
    if part == "pelvis":
        yield TROUSERS, up < 2.0
        yield BELT, (up > 0.72) & (up < 0.86)
        yield STRIPE, (up > 0.74) & (up < 0.84) & (np.abs(across - 0.5) < 0.04)
    if part in ("thigh", "shank"):
        yield TROUSERS, up < 2.0
        yield CUFF, (np.abs(across * 4.0 % 1.0 - 0.5) < 0.06) | ((up > 0.84) & (part == "shank"))
    if part == "foot":
        yield SHOE, up < 2.0
        yield SOLE, (up * 8.0 % 1.0) < 0.2
    if part == "head":
        yield HAIR, (up > 0.72) | ((np.abs(across - 0.5) > 0.2) & (up > 0.4))
        yield EYE, (np.abs(np.abs(across - 0.5) - 0.07) < 0.022) & (np.abs(up - 0.56) < 0.03)


def textured_material(pixels):
    """A Principled material with the picture (h, w, 4), which is packed."""
    image = bpy.data.images.new("Game Figure", *pixels.shape[:2])
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.pack()
    material = scene_mesh.plain_material("Game Figure", (0.8, 0.8, 0.8), 0.6)
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = material.node_tree.nodes["Principled BSDF"]
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return material
