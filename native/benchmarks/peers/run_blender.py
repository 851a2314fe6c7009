# SPDX-License-Identifier: MPL-2.0
"""Run by Blender: its Laplacian Deform, driven by one Hook for each piece. Arguments after --: the job's folder.

Options: `iterations`, the modifier's Repeat. It has no memory of the last frame: every step is from the rest shape.
"""

import pathlib
import sys
import traceback

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))

from native.benchmarks.peers import worker
from native.benchmarks.rigid import rigid_fit


class Steps:
    """The modifier is bound once; a step moves the Hooks' empties and reads the evaluated mesh."""

    def __init__(self, job):
        self.count = len(job.vertices)
        self.obj = mesh_object(job.vertices, job.faces)
        self.rest, self.members, self.empties = job.vertices[job.anchors], [], []
        for piece in np.unique(job.pieces[job.pieces >= 0]):
            members = np.flatnonzero(job.pieces == piece)
            self.members.append(members)
            self.empties.append(self.hook(job.anchors[members]))
        group = self.obj.vertex_groups.new(name="anchors")
        group.add(job.anchors.tolist(), 1.0, "REPLACE")
        modifier = self.obj.modifiers.new("laplacian", "LAPLACIANDEFORM")
        modifier.vertex_group, modifier.iterations = group.name, job.options["iterations"]
        bpy.context.view_layer.objects.active = self.obj
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
        self.depsgraph = bpy.context.evaluated_depsgraph_get()
        self.depsgraph.update()
        if not modifier.is_bind:
            raise RuntimeError("the modifier did not bind")

    def hook(self, vertex_numbers):
        """The empty that moves these vertices rigidly."""
        empty = bpy.data.objects.new("handle", None)
        bpy.context.collection.objects.link(empty)
        hook = self.obj.modifiers.new("hook", "HOOK")
        hook.object, hook.falloff_type = empty, "NONE"
        hook.vertex_indices_set(vertex_numbers.tolist())
        hook.matrix_inverse = Matrix.Identity(4)  # the empty is at the origin
        return empty

    def __call__(self, targets, restart):
        for members, empty in zip(self.members, self.empties, strict=True):
            rotation, shift = rigid_fit(self.rest[members], targets[members])
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = rotation, shift
            empty.matrix_world = Matrix(matrix.tolist())
        self.depsgraph.update()
        positions = np.empty(3 * self.count, np.float32)
        self.obj.evaluated_get(self.depsgraph).data.vertices.foreach_get("co", positions)
        return positions.reshape(-1, 3).astype(np.float64)


def mesh_object(vertices, faces):
    """A mesh object of triangles in an otherwise empty file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("mesh")
    mesh.from_pydata(vertices.tolist(), [], faces.tolist())
    mesh.update()
    obj = bpy.data.objects.new("mesh", mesh)
    bpy.context.collection.objects.link(obj)
    return obj


if __name__ == "__main__":
    try:
        worker.serve(sys.argv[sys.argv.index("--") + 1], Steps)
    except Exception:
        traceback.print_exc()
        sys.exit(1)
