# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh that the demo models: the octopus of Figure 5."""

import numpy as np
from support import steps

from . import creature, scene_mesh
from .subject import Subject, View, bent_chord

ANCHOR_AT = 0.70  # fraction of the lifted tentacle's length: just before its tip begins to roll
# The region takes in the tentacle's whole root, so that the root turns with it. Its border crosses an eye, as
# in Figure 5. With the thin part alone as region the same lift bends it so much that it changes thickness.
ROI_RADIUS = 0.85
LIFT_ANGLE_DEG = 50.0

SKIN_COLOUR, WART_COLOUR = np.array([0.50, 0.085, 0.035]), np.array([0.72, 0.30, 0.10])
SUCKER_COLOUR = np.array([0.90, 0.62, 0.50])
EYE_COLOUR, PUPIL_COLOUR = (0.90, 0.80, 0.45), (0.01, 0.01, 0.015)


class Lift:
    """The tentacle that is lifted by one anchor vertex, near its tip."""

    def __init__(self, model):
        self._vertices = model.mesh.vertices
        self.tentacle = model.tentacle_vertices(creature.LIFTED_TENTACLE, 0.0)
        self.root = self._vertices[self.tentacle & (model.mesh.along < 0.08)].mean(axis=0)
        self.anchor = model.upper_vertex(creature.LIFTED_TENTACLE, ANCHOR_AT)

    def target(self, degrees):
        """Where the anchor goes, (3,)."""
        rest = self._vertices[self.anchor]
        outwards = (rest - self.root) * [1.0, 1.0, 0.0]
        return bent_chord(rest, self.root, np.cross(outwards, [0.0, 0.0, 1.0]), np.radians(degrees))


def octopus(model=None):
    """The creature with one tentacle and its surroundings as region, lifted by one anchor vertex."""
    model = model or creature.build_creature()
    mesh = model.mesh
    obj = scene_mesh.new_object("Octopus", mesh.vertices, mesh.quads)
    scene_mesh.shade_smooth(obj)
    scene_mesh.set_vertex_colours(obj, octopus_colours(model))
    scene_mesh.set_face_materials(
        obj,
        [
            scene_mesh.tinted_material("Skin", tuple(SKIN_COLOUR), 0.40),
            scene_mesh.tinted_material("Sucker", tuple(SUCKER_COLOUR), 0.40),
            scene_mesh.plain_material("Eye", EYE_COLOUR, 0.20),
            scene_mesh.plain_material("Pupil", PUPIL_COLOUR, 0.10),
        ],
        mesh.part,
    )
    lift = Lift(model)
    roi = lift.tentacle | (np.linalg.norm(mesh.vertices - lift.root, axis=1) < ROI_RADIUS)
    steps.add_group(obj, "tentacle region", np.flatnonzero(roi))
    steps.add_group(obj, "tip", [lift.anchor])

    targets = mesh.vertices.copy()
    targets[lift.anchor] = lift.target(LIFT_ANGLE_DEG)
    return Subject(
        title="Octopus, one tentacle lifted by one anchor",
        file_stem="octopus",
        obj=obj,
        handles=("tip",),
        roi_group="tentacle region",
        targets=targets,
        view=View(azimuth_deg=12.0, elevation_deg=20.0, height=640),
    )


def octopus_colours(model):
    """Linear RGB (n, 3): pale warts on the skin, and suckers that fade into it at their foot."""
    wart = model.wart[:, None]
    colours = (1.0 - wart) * SKIN_COLOUR + wart * WART_COLOUR
    colours[model.mesh.vertices_of_faces(model.mesh.part == creature.SUCKER)] = SUCKER_COLOUR
    return colours
