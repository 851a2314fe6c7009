# SPDX-License-Identifier: GPL-3.0-or-later
"""An octopus-like creature: one closed manifold quad mesh with eyes, eight tentacles and suckers. No bpy."""

from dataclasses import dataclass, replace

import numpy as np

from .quad_mesh import QuadCage, QuadMesh, subdivide
from .tentacle import TentacleShape, add_tentacle, centre_line

SKIN, SUCKER, EYE, PUPIL = range(4)

SEGMENTS = 32  # cage vertices around the body
TENTACLES = 8
TENTACLE_RINGS = 29
LIFTED_TENTACLE = 7  # front right, seen by a camera on the -y side

# Rings of the body's cage from the mantle's top to the underside: height, radius, shift to the back.
BODY_RINGS = np.array(
    [
        [2.11, 0.12, 0.34],
        [2.09, 0.24, 0.34],
        [2.05, 0.36, 0.34],
        [1.99, 0.47, 0.33],
        [1.91, 0.57, 0.32],
        [1.81, 0.66, 0.30],
        [1.70, 0.73, 0.28],
        [1.58, 0.77, 0.25],
        [1.45, 0.80, 0.22],
        [1.34, 0.80, 0.18],
        [1.23, 0.78, 0.14],
        [1.11, 0.73, 0.10],
        [0.96, 0.66, 0.05],
        [0.83, 0.60, 0.02],
        [0.71, 0.57, 0.00],
        [0.60, 0.59, 0.00],
        [0.16, 0.56, 0.00],
        [0.12, 0.36, 0.00],
        [0.14, 0.17, 0.00],
    ]
)
TENTACLE_ROW = 15  # tentacles leave between this ring and the next
EYE_ROW = 10  # first of the four rows of quads that an eye takes
EYE_COLUMNS = (19, 25)  # first of the four columns, right eye and left eye; -y is column 24
EYE_RADIUS, EYE_DEPTH = 0.20, 0.02
# An eye's rings from its rim inwards: angle from the viewing direction, radius over EYE_RADIUS, face label.
EYE_RINGS = (
    (105.0, 1.25, SKIN),
    (75.0, 1.28, SKIN),
    (62.0, 1.20, SKIN),
    (62.0, 1.00, EYE),
    (48.0, 1.02, EYE),
    (34.0, 1.02, EYE),
    (28.0, 1.02, PUPIL),
    (15.0, 1.02, PUPIL),
)
WART_COUNT, WART_HEIGHT, WART_WIDTH = 800, 0.42, 1.05  # height and width over the local quad size
WART_SIZE_LIMIT = 0.055


@dataclass(frozen=True)
class Creature:
    """The mesh and where things are on it. Face labels are in mesh.part (SKIN to PUPIL) and mesh.limb."""

    mesh: QuadMesh
    wart: np.ndarray  # (n,), 0 on plain skin to 1 on top of a wart

    def tentacle_vertices(self, tentacle, from_s, to_s=1.1):
        """Boolean (n,): vertices of one tentacle between the fractions `from_s` and `to_s` of its length."""
        on_tentacle = self.mesh.vertices_of_faces(self.mesh.limb == tentacle)
        return on_tentacle & (self.mesh.along >= from_s) & (self.mesh.along < to_s)

    def upper_vertex(self, tentacle, s):
        """Index of the vertex on the upper side of a tentacle nearest the fraction `s` of its length."""
        skin = self.mesh.vertices_of_faces((self.mesh.limb == tentacle) & (self.mesh.part == SKIN))
        near = np.flatnonzero(skin & (np.abs(self.mesh.along - s) < 0.02))
        return int(near[np.argmax(self.mesh.vertices[near, 2])])


def build_creature(seed=3):
    """The creature, 18,850 vertices and about 6 units across. The same seed gives the same bits."""
    random = np.random.default_rng(seed)
    cage = QuadCage()
    rings = add_body(cage)
    add_eyes(cage, rings)
    for tentacle in range(TENTACLES):
        loop = tentacle_root(rings, tentacle)
        root = np.mean([cage.vertices[v] for v in loop], axis=0)
        line = centre_line(tentacle_shape(tentacle, root[2], random), root)
        add_tentacle(cage, loop, line, tentacle, TENTACLE_RINGS, SKIN, SUCKER)
    return add_warts(subdivide(cage.mesh()), random)


def add_body(cage):
    """Adds the body's rings and faces, leaving out the tentacles' row and the eyes; returns the rings' indices."""
    azimuth = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    around = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(SEGMENTS)], axis=1)
    rings = [cage.add_vertices(radius * around + [0.0, shift, height]) for height, radius, shift in BODY_RINGS]
    for row in range(len(rings) - 1):
        for column in range(SEGMENTS):
            if row != TENTACLE_ROW and not is_eye(row, column):
                right = (column + 1) % SEGMENTS
                upper, lower = rings[row], rings[row + 1]
                cage.add_quad([upper[column], lower[column], lower[right], upper[right]])
    cage.cap(rings[0], [0.0, BODY_RINGS[0, 2], BODY_RINGS[0, 0] + 0.005])
    cage.cap(rings[-1][::-1], [0.0, 0.0, BODY_RINGS[-1, 0] + 0.03])
    return rings


def is_eye(row, column):
    """Whether an eye takes the place of this quad of the body."""
    return EYE_ROW <= row < EYE_ROW + 4 and any(first <= column < first + 4 for first in EYE_COLUMNS)


def add_eyes(cage, rings):
    """Fills each eye's hole with a lid, a ball and a pupil."""
    for first in EYE_COLUMNS:
        rows, columns = range(EYE_ROW, EYE_ROW + 5), range(first, first + 5)
        loop = [rings[row][columns[0]] for row in rows]
        loop += [rings[rows[-1]][column] for column in columns[1:]]
        loop += [rings[row][columns[-1]] for row in reversed(rows[:-1])]
        loop += [rings[rows[0]][column] for column in reversed(columns[1:-1])]
        add_eye(cage, loop, cage.vertices[rings[EYE_ROW + 2][first + 2]])


def add_eye(cage, loop, centre):
    """Concentric rings from the hole's border `loop` up and over a ball about the point `centre` (3,)."""
    outward = np.array([centre[0], centre[1], 0.0]) / np.hypot(centre[0], centre[1])
    right, up = np.cross([0.0, 0.0, 1.0], outward), np.array([0.0, 0.0, 1.0])
    ball = centre + EYE_DEPTH * outward
    first = cage.vertices[loop[0]] - ball
    turn = np.arctan2(first @ up, first @ right) + 2.0 * np.pi * np.arange(len(loop)) / len(loop)
    spokes = np.cos(turn)[:, None] * right + np.sin(turn)[:, None] * up
    for angle_deg, size, part in EYE_RINGS:
        angle, radius = np.radians(angle_deg), size * EYE_RADIUS
        ring = cage.add_vertices(ball + radius * (np.cos(angle) * outward + np.sin(angle) * spokes))
        cage.bridge(loop, ring, part)
        loop = ring
    cage.cap(loop, ball + EYE_RADIUS * outward, part=PUPIL)


def tentacle_root(rings, tentacle):
    """The ten cage vertices that a tentacle grows from, in the order of tentacle.SECTION_ANGLE_DEG."""
    columns = [(4 * tentacle + k) % SEGMENTS for k in range(5)]
    top, bottom = rings[TENTACLE_ROW], rings[TENTACLE_ROW + 1]
    return [top[columns[0]], *(bottom[c] for c in columns), *(top[c] for c in reversed(columns[1:]))]


def tentacle_shape(tentacle, root_height, random):
    """A resting tentacle: random waves and a rolled tip; the one to be lifted lies nearly straight."""
    heading = 2.0 * np.pi * (tentacle + 0.5) / TENTACLES
    shape = TentacleShape(
        heading=heading,
        length=random.uniform(2.8, 3.2),
        root_radius=0.20,
        tip_radius=0.03,
        root_height=root_height,
        sway=random.uniform(0.25, 0.5) * random.choice([-1.0, 1.0]),
        sway_phase=random.uniform(0.0, 2.0 * np.pi),
        curl_up=random.choice([0.0, 4.5]),
        curl_side=random.uniform(2.5, 4.5) * random.choice([-1.0, 1.0]),
    )
    if tentacle != LIFTED_TENTACLE:
        return shape
    return replace(shape, length=3.2, sway=0.12, sway_phase=0.0, curl_up=3.6, curl_side=0.0, curl_start=0.72)


def add_warts(mesh, random):
    """The Creature: `mesh` with small round bumps all over the skin, so that lost detail would show."""
    corner = mesh.vertices[mesh.quads]
    # The longest edge, not the area: on thin quads a bump narrower than an edge would alias.
    quad_size = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    size = np.zeros(len(mesh.vertices))
    np.add.at(size, mesh.quads.ravel(), np.repeat(quad_size, 4))
    size /= np.bincount(mesh.quads.ravel())

    skin = np.flatnonzero(mesh.vertices_of_faces(mesh.part == SKIN))
    profile = np.zeros(len(mesh.vertices))
    for wart in random.choice(skin, WART_COUNT, replace=False):
        distance = np.linalg.norm(mesh.vertices[skin] - mesh.vertices[wart], axis=1) / size[wart]
        profile[skin] = np.maximum(profile[skin], np.exp(-0.5 * (distance / WART_WIDTH) ** 2))
    size = np.minimum(size, WART_SIZE_LIMIT)
    raised = mesh.vertices + (WART_HEIGHT * size * profile)[:, None] * mesh.vertex_normals()
    return Creature(replace(mesh, vertices=raised), profile)
