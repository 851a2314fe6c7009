# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays to Blender mesh objects: faces, labels as materials, vertex groups, colours."""

import bpy
import numpy as np

COLOUR_ATTRIBUTE = "Tint"


def new_object(name, vertices, polygons):
    """Links a new mesh object to the scene.

    vertices (n, 3); polygons: (m, k) array or list of index lists. Vertex order is kept.
    """
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices).tolist(), [], [list(map(int, polygon)) for polygon in polygons])
    mesh.update()
    obj = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def edges(obj):
    """Vertex indices of the mesh's edges, (e, 2)."""
    ends = np.empty(2 * len(obj.data.edges), dtype=np.int32)
    obj.data.edges.foreach_get("vertices", ends)
    return ends.reshape(-1, 2)


def connected_part(inside, start, ends):
    """(n,) bool: those of `inside` (n,) that the vertex `start` reaches along edges `ends` (e, 2) between them."""
    ends = ends[inside[ends].all(axis=1)]
    reached = np.zeros(len(inside), dtype=bool)
    reached[start] = True
    while len(border := ends[reached[ends].sum(axis=1) == 1]):
        reached[border] = True
    return reached


def shade_smooth(obj):
    """Smooth shading on every face."""
    obj.data.polygons.foreach_set("use_smooth", np.ones(len(obj.data.polygons), dtype=bool))
    obj.data.update()


def set_vertex_colours(obj, colours):
    """Stores linear RGB `colours` (n, 3) as the vertex attribute that tinted materials read."""
    attribute = obj.data.color_attributes.new(COLOUR_ATTRIBUTE, "FLOAT_COLOR", "POINT")
    rgba = np.ones((len(colours), 4), dtype=np.float32)
    rgba[:, :3] = colours
    attribute.data.foreach_set("color", rgba.ravel())


def set_face_materials(obj, materials, index):
    """Gives the object `materials` in order and each face the one at `index` (m,)."""
    for material in materials:
        obj.data.materials.append(material)
    obj.data.polygons.foreach_set("material_index", np.asarray(index, dtype=np.int32))
    obj.data.update()


def plain_material(name, colour, roughness=0.5):
    """A Principled material of one linear RGB colour."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.diffuse_color = (*colour, 1.0)  # what Workbench and the viewport's solid mode show
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1.0)
    shader.inputs["Roughness"].default_value = roughness
    return material


def tinted_material(name, colour, roughness=0.5):
    """A Principled material coloured by set_vertex_colours; `colour` is what solid mode shows."""
    material = plain_material(name, colour, roughness)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    attribute = nodes.new("ShaderNodeAttribute")
    attribute.attribute_name = COLOUR_ATTRIBUTE
    links.new(attribute.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return material
