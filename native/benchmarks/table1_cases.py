# SPDX-License-Identifier: MPL-2.0
"""The deformations of the paper's Table 1, as near as the models at hand allow: models, regions, anchors, moves."""

import heapq
from dataclasses import dataclass, field

import numpy as np

from blender_tests.demo import creature
from blender_tests.support import mesh_files
from native.benchmarks import bench_encode

LIMB_REACH = 0.25  # edge distance from a limb's tip to where it is turned, over the diagonal
SLENDER = 0.6  # a tip whose limb is rounder than this is held instead: distance to the turn's centre over the reach


@dataclass(frozen=True)
class PaperRow:
    """A row of the paper's Table 1; energies by method, and seconds on its Pentium 4 at 3 GHz."""

    vertex_count: int
    roi_count: int
    anchor_count: int
    energies: dict
    encode_seconds: float
    decode_seconds: float


@dataclass(frozen=True)
class Case:
    """One deformation: (n, 3) vertices, triangles, anchors with their targets, and roi (n,) bool, what may move."""

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    anchors: np.ndarray
    targets: np.ndarray
    roi: np.ndarray
    paper: PaperRow = field(repr=False)

    @property
    def diagonal(self):
        """Of the rest shape's bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


FELINE = PaperRow(49864, 34759, 9, {"paper": 0.000232}, 6.65, 0.863)
OCTOPUS = PaperRow(149678, 19196, 1, {"paper": 0.000003}, 3.52, 0.745)
DOLPHIN = PaperRow(
    5937, 1156, 1, {"paper": 0.000146, "pyramid": 0.001061, "surface editing": 0.006401, "laplacian": 0.011042},
    0.190, 0.054,
)  # fmt: skip


def cases():
    """The three deformations, in the order of the table."""
    return [feline(), octopus(), dolphin()]


def feline():
    """Feet and tail turned to and fro by 30 degrees; head, neck and wings fixed; 9 anchors far from each other."""
    read = read_model("feline.off", "the creature of the demo")
    if read:
        vertices, faces = read
        lateral, fixed_side = np.array([0.0, 1.0, 0.0]), np.array([0.5, 0.0, -1.0])
    else:
        vertices, faces = creature_triangles()
        lateral, fixed_side = np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0])
    roi_count = round(FELINE.roi_count / FELINE.vertex_count * len(vertices))
    roi = np.zeros(len(vertices), bool)
    roi[np.argsort(vertices @ fixed_side, kind="stable")[:roi_count]] = True
    edges = Edges(vertices, faces)
    anchors = far_points(edges, np.flatnonzero(~roi), FELINE.anchor_count)
    reach = LIMB_REACH * np.linalg.norm(np.ptp(vertices, axis=0))
    targets = vertices[anchors]
    for k, anchor in enumerate(anchors):
        centre = limb_centre(vertices, edges, anchor, reach)
        if np.linalg.norm(vertices[anchor] - centre) > SLENDER * reach:
            targets[k] = turned(vertices[anchor], centre, lateral, 30.0 * (-1) ** k)
    return Case("feline", vertices, faces, anchors, targets, roi, FELINE)


def octopus():
    """One tentacle lifted by its tip, by 45 degrees about the region's border."""
    read = read_model("octopus.off", "the creature of the demo")
    if read:
        vertices, faces = read
        tip, up = int(vertices[:, 1].argmin()), np.array([0.0, 1.0, 0.0])
    else:
        vertices, faces = creature_triangles()
        made = creature.build_creature()
        outer = made.tentacle_vertices(creature.LIFTED_TENTACLE, 0.9)
        tip = int(np.where(outer, made.mesh.along, -1.0).argmax())
        up = np.array([0.0, 0.0, 1.0])
    return lifted("octopus", vertices, faces, tip, up, 45.0, OCTOPUS)


def dolphin():
    """The tail lifted by 40 degrees by one vertex in the notch of its flukes: Figure 6."""
    rank = None
    read = read_model("dolphin_quads_open.obj", "a torus")
    if read:
        vertices, faces = read
        off_middle = np.abs(vertices[:, 2] - np.mean(vertices[:, 2]))
        middle = off_middle < 0.02 * np.linalg.norm(np.ptp(vertices, axis=0))
        tip, up = int(np.where(middle, vertices[:, 0], -np.inf).argmax()), np.array([0.0, 1.0, 0.0])
        rank = -vertices[:, 0]  # the edges lead from the notch past the flukes' tips, which must move too
    else:
        vertices, faces = bench_encode.generated_torus(120, 48)
        tip, up = int(vertices[:, 0].argmax()), np.array([0.0, 0.0, 1.0])
    return lifted("dolphin", vertices, faces, tip, up, 40.0, DOLPHIN, rank)


def lifted(name, vertices, faces, tip, up, angle_deg, paper, rank=None):
    """The tip turns up about the region's border; the region has the paper's share of the vertices.

    rank: (n,) the lowest are in the region; None for those nearest to the tip along the edges.
    """
    edges = Edges(vertices, faces)
    rank = edges.distances([tip]) if rank is None else rank
    roi_count = round(paper.roi_count / paper.vertex_count * len(vertices))
    roi = np.zeros(len(vertices), bool)
    roi[np.argsort(rank, kind="stable")[:roi_count]] = True
    centre = vertices[edges.border(roi)].mean(axis=0)
    axis = np.cross(vertices[tip] - centre, up)
    target = turned(vertices[tip], centre, axis, angle_deg)
    return Case(name, vertices, faces, np.array([tip]), target[None], roi, paper)


def read_model(name, instead):
    """(vertices, triangles) of a model of the shared data, or None with a printed note."""
    path = mesh_files.DATA / "models" / name
    if path.exists():
        return mesh_files.read_triangles(path)
    print(f"no {name} in the shared data: {instead} instead (generated)")
    return None


def creature_triangles():
    """The demo's generated creature: (n, 3) vertices, (m, 3) triangles."""
    mesh = creature.build_creature().mesh
    return mesh.vertices, mesh.triangles()


def turned(point, centre, axis, angle_deg):
    """`point` rotated about an axis through `centre` (Rodrigues)."""
    axis = axis / np.linalg.norm(axis)
    angle, arm = np.radians(angle_deg), point - centre
    along = axis * (axis @ arm)
    return centre + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm)


def limb_centre(vertices, edges, tip, reach):
    """Where the limb of `tip` is turned: the middle of the vertices at an edge distance of `reach`, within 3 %."""
    distance = edges.distances([tip])
    return vertices[np.abs(distance - reach) < 0.03 * reach].mean(axis=0)


def far_points(edges, sources, count):
    """Numbers of `count` vertices, each as far along the edges as can be from `sources` and those before."""
    chosen = []
    distance = edges.distances(sources)
    for _ in range(count):
        chosen.append(int(np.where(np.isfinite(distance), distance, -1.0).argmax()))
        distance = np.minimum(distance, edges.distances(chosen[-1:]))
    return np.array(chosen)


class Edges:
    """The edges of a triangle mesh with their lengths, for shortest paths."""

    def __init__(self, vertices, faces):
        pairs = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
        self.pairs = np.unique(np.concatenate([pairs, pairs[:, ::-1]]), axis=0)
        lengths = np.linalg.norm(vertices[self.pairs[:, 0]] - vertices[self.pairs[:, 1]], axis=1)
        ends = np.searchsorted(self.pairs[:, 0], np.arange(len(vertices) + 1))
        # Lists: heapq walks them several times as fast as arrays.
        self.first, self.other, self.length = ends.tolist(), self.pairs[:, 1].tolist(), lengths.tolist()

    def distances(self, sources):
        """(n,) lengths of the shortest edge paths from `sources` (Dijkstra); inf where there is none."""
        distance = [float("inf")] * (len(self.first) - 1)
        heap = [(0.0, int(source)) for source in sources]
        for _, source in heap:
            distance[source] = 0.0
        while heap:
            reached, vertex = heapq.heappop(heap)
            if reached > distance[vertex]:
                continue
            for k in range(self.first[vertex], self.first[vertex + 1]):
                through = reached + self.length[k]
                if through < distance[self.other[k]]:
                    distance[self.other[k]] = through
                    heapq.heappush(heap, (through, self.other[k]))
        return np.array(distance)

    def border(self, roi):
        """Numbers of the vertices of `roi` (n,) that an edge joins to the rest."""
        inside, outside = roi[self.pairs[:, 0]], roi[self.pairs[:, 1]]
        return np.unique(self.pairs[inside & ~outside, 0])
