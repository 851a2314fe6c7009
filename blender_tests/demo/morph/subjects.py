# SPDX-License-Identifier: GPL-3.0-or-later
"""What is mixed with what. No bpy."""

from dataclasses import dataclass

import numpy as np
from support import figure_body, walking_figure

from .. import built_in, creature
from ..tentacle import smoothstep

OTHER_SEED = 11
BODY_COLOUR = (0.52, 0.40, 0.33)
ELBOW_DEG, ARM_DEG = 125.0, 75.0


@dataclass(frozen=True, eq=False)
class Subject:
    """A mesh and the shape that it is mixed with.

    rest, other (n, 3); polygons; colours (n, 3); parts (m,) material of each face, 0 to 3; mask (n,) where the other
    enters, or None for everywhere; values: of the slider, for the row; azimuth_deg, elevation_deg: of the camera.
    """

    title: str
    stem: str
    rest: np.ndarray
    other: np.ndarray
    polygons: np.ndarray
    colours: np.ndarray
    parts: np.ndarray
    mask: np.ndarray
    values: tuple
    azimuth_deg: float
    elevation_deg: float


def creatures():
    """From one octopus to another, as the paper's Figure 11."""
    first, second = creature.build_creature(), _other_creature()
    return _of_creature("From one creature to another", "morph_creatures", first, second.mesh.vertices, None, 6)


def grafted():
    """The other octopus' front tentacles on the first one's body, as the paper's Figure 10."""
    first, second = creature.build_creature(), _other_creature()
    mask = np.zeros(len(first.mesh.vertices))
    for tentacle in (4, 5, 6, 7):
        mine = first.tentacle_vertices(tentacle, 0.0)
        mask[mine] = np.maximum(mask, smoothstep(0.04, 0.25, first.mesh.along))[mine]
    return _of_creature("Tentacles of another creature", "morph_graft", first, second.mesh.vertices, mask, 3)


def flexing():
    """A shape key that bends both arms: half-way, straight lines make them thin and short."""
    shape = figure_body.body()
    joints, turns = walking_figure.upright(1, 1.0)
    turns = dict(turns)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        turns[f"upper_arm.{side}"] = walking_figure.turn_y(np.radians([sign * ARM_DEG]))
        bend = walking_figure.turn_z(np.radians([-sign * ELBOW_DEG]))
        turns[f"forearm.{side}"] = turns[f"upper_arm.{side}"] @ bend
    joints = {**joints, **walking_figure.trunk_and_arms(joints["pelvis"], turns)}
    posed = figure_body.posed(shape, joints, turns)[0]
    colours = np.tile(BODY_COLOUR, (len(posed), 1))
    parts = np.zeros(len(shape.quads), int)
    return Subject(
        "A shape key that bends the arms", "morph_arms", shape.vertices, posed, shape.quads, colours, parts, None,
        _evenly(5), 12.0, 4.0,
    )  # fmt: skip


MAKERS = {"arms": flexing, "creatures": creatures, "graft": grafted}


def _other_creature():
    """Taller and narrower, with other tentacles."""
    found = creature.build_creature(OTHER_SEED)
    upper = smoothstep(0.5, 2.0, found.mesh.vertices[:, 2])[:, None]
    found.mesh.vertices[:] *= 1.0 + upper * np.array([-0.28, -0.12, 0.42])
    return found


def _of_creature(title, stem, first, other, mask, steps):
    mesh = first.mesh
    return Subject(
        title, stem, mesh.vertices, other, mesh.quads, built_in.octopus_colours(first), mesh.part, mask,
        _evenly(steps), 12.0, 20.0,
    )  # fmt: skip


def _evenly(count):
    return tuple(np.linspace(0.0, 1.0, count).tolist())
