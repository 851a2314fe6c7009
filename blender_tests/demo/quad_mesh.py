# SPDX-License-Identifier: GPL-3.0-or-later
"""Closed quad meshes as arrays: a cage to build on, and Catmull-Clark subdivision to smooth it.

Written here rather than left to Blender's modifiers so that every Blender version, and plain Python,
gets the same vertices in the same order. No bpy.
"""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class QuadMesh:
    """A closed manifold quad mesh with one label per face and one number per vertex.

    vertices (n, 3) float64; quads (m, 4) int32, counter-clockwise seen from outside;
    part (m,) int32 and limb (m,) int32, face labels; along (n,) float64, any smooth vertex value.
    """

    vertices: np.ndarray
    quads: np.ndarray
    part: np.ndarray
    limb: np.ndarray
    along: np.ndarray

    def vertex_normals(self):
        """Area-weighted unit normals, (n, 3)."""
        corner = self.vertices[self.quads]
        face_normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        normal = np.zeros_like(self.vertices)
        for k in range(4):
            np.add.at(normal, self.quads[:, k], face_normal)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def vertices_of_faces(self, face_mask):
        """Boolean (n,): vertices all of whose faces are in `face_mask` (m,)."""
        inside = np.ones(len(self.vertices), dtype=bool)
        inside[self.quads[~face_mask].ravel()] = False
        return inside


@dataclass
class QuadCage:
    """A quad mesh under construction: grows by vertices, quads, tubes and caps."""

    vertices: list = field(default_factory=list)
    along: list = field(default_factory=list)
    quads: list = field(default_factory=list)
    part: list = field(default_factory=list)
    limb: list = field(default_factory=list)

    def add_vertices(self, positions, along=0.0):
        """Appends `positions` (k, 3), all with the value `along`; returns their indices."""
        first = len(self.vertices)
        self.vertices.extend(np.asarray(position, dtype=float) for position in positions)
        self.along.extend([float(along)] * len(positions))
        return list(range(first, len(self.vertices)))

    def add_quad(self, corners, part=0, limb=-1):
        """Appends one quad and returns its index."""
        self.quads.append(list(corners))
        self.part.append(part)
        self.limb.append(limb)
        return len(self.quads) - 1

    def bridge(self, inner, outer, part=0, limb=-1):
        """Quads between two closed loops of equal length.

        The loops run counter-clockwise seen from the side that `outer` lies on. Returns the quads' indices.
        """
        count = len(inner)
        return [
            self.add_quad([inner[k], inner[(k + 1) % count], outer[(k + 1) % count], outer[k]], part, limb)
            for k in range(count)
        ]

    def cap(self, loop, position, along=0.0, part=0, limb=-1):
        """Closes a loop of even length around a new vertex, two loop edges to a quad."""
        (centre,) = self.add_vertices([position], along)
        for k in range(0, len(loop), 2):
            self.add_quad([centre, loop[k], loop[k + 1], loop[(k + 2) % len(loop)]], part, limb)

    def inset(self, quad_index, scale, height, part):
        """Replaces a quad by a ring of four and an inner quad, scaled about its centre and raised.

        scale: inner size over outer size; height: over the square root of the outer quad's area.
        Returns the inner quad's index (the same as `quad_index`).
        """
        corners = self.quads[quad_index]
        position = np.array([self.vertices[v] for v in corners])
        centre = position.mean(axis=0)
        area_vector = 0.5 * np.cross(position[2] - position[0], position[3] - position[1])
        area = np.linalg.norm(area_vector)
        raised = centre + scale * (position - centre) + height * area_vector / np.sqrt(area)
        inner = self.add_vertices(raised, np.mean([self.along[v] for v in corners]))
        self.bridge(corners, inner, part, self.limb[quad_index])
        self.quads[quad_index] = inner
        self.part[quad_index] = part
        return quad_index

    def mesh(self):
        """The cage as a QuadMesh, without vertices that no quad uses."""
        used, quads = np.unique(np.array(self.quads), return_inverse=True)
        quads = quads.reshape(-1, 4).astype(np.int32)
        return QuadMesh(
            vertices=np.array(self.vertices)[used],
            quads=quads,
            part=np.array(self.part, dtype=np.int32),
            limb=np.array(self.limb, dtype=np.int32),
            along=np.array(self.along)[used],
        )


def subdivide(mesh):
    """One step of Catmull-Clark subdivision; face labels are inherited, `along` is interpolated linearly.

    Vertices come out in the order: old vertices, edge points, face points.
    """
    quads, vertex_count, face_count = mesh.quads, len(mesh.vertices), len(mesh.quads)
    half_edges = np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2)
    edges, edge_of_half = np.unique(np.sort(half_edges, axis=1), axis=0, return_inverse=True)
    edge_of_half = edge_of_half.reshape(-1)
    face_of_half = np.repeat(np.arange(face_count), 4)

    face_point = mesh.vertices[quads].mean(axis=1)
    midpoint = mesh.vertices[edges].mean(axis=1)
    face_sum = np.zeros_like(midpoint)
    np.add.at(face_sum, edge_of_half, face_point[face_of_half])
    edge_point = 0.5 * midpoint + 0.25 * face_sum  # every edge of a closed mesh has two faces

    valence = np.bincount(quads.ravel(), minlength=vertex_count)[:, None]
    face_mean, midpoint_mean = np.zeros_like(mesh.vertices), np.zeros_like(mesh.vertices)
    np.add.at(face_mean, quads.ravel(), face_point[face_of_half])
    np.add.at(midpoint_mean, edges.ravel(), np.repeat(midpoint, 2, axis=0))
    face_mean, midpoint_mean = face_mean / valence, midpoint_mean / valence
    vertex_point = (face_mean + 2.0 * midpoint_mean + (valence - 3) * mesh.vertices) / valence

    edge_index = vertex_count + edge_of_half.reshape(face_count, 4)
    face_index = np.broadcast_to(vertex_count + len(edges) + np.arange(face_count)[:, None], quads.shape)
    children = np.stack([quads, edge_index, face_index, np.roll(edge_index, 1, axis=1)], axis=2)
    return QuadMesh(
        vertices=np.concatenate([vertex_point, edge_point, face_point]),
        quads=children.reshape(-1, 4).astype(np.int32),
        part=np.repeat(mesh.part, 4),
        limb=np.repeat(mesh.limb, 4),
        along=np.concatenate([mesh.along, mesh.along[edges].mean(axis=1), mesh.along[quads].mean(axis=1)]),
    )
