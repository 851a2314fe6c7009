# SPDX-License-Identifier: GPL-3.0-or-later
"""Who is moved by which capture. No bpy."""

from dataclasses import dataclass, field

import numpy as np
from support import capture_files, figure_body, sitting_figure, walking_figure

SPACING = 0.0155  # metres between vertices
GAPS, NOISE = 0.06, 0.0007  # of the generated captures: share of the samples, metres


@dataclass(frozen=True, eq=False)
class Subject:
    """A mesh, the files that move it, and which samples are shown.

    vertices (n, 3) metres, Z up; polygons; take, standing: paths of the motion and of the reference; shown: samples of
    the film strip; box: (low (3,), high (3,)) of a seat, or None. Where the truth is known: truth (f, n, 3), planted:
    [(begin, end, vertices)] of feet that stand; height in metres.
    """

    title: str
    stem: str
    vertices: np.ndarray
    polygons: object
    take: object
    standing: object
    shown: np.ndarray
    mode: str = "AS_CAPTURED"
    low_pass_hz: float = 8.0
    box: tuple = None
    truth: np.ndarray = None
    planted: list = field(default_factory=list)

    @property
    def height(self):
        return float(np.ptp(self.vertices[:, 2]))


def walk(folder, spacing=SPACING, frames=170):
    """The figure walks: two steps are shown."""
    shape, figure = figure_body.body(1.0, spacing), walking_figure.take(frames, 7, 1.0, GAPS, NOISE)
    moves = walking_figure.walking(np.arange(frames) / figure.rate_hz)
    return generated(
        folder, "Walk: 41 markers, gaps and noise", "walk", shape, figure, steps_of(frames), truth=truth(shape, moves)
    )


def short_legs(folder, spacing=SPACING, frames=170, legs=0.7):
    """The same capture on a figure with shorter legs. Where its feet stand is not known, but when they do."""
    shape, figure = figure_body.body(legs, spacing), walking_figure.take(frames, 7, 1.0, GAPS, NOISE)
    title = "Walk, retargeted to legs 30 % shorter"
    return generated(folder, title, "walk_short_legs", shape, figure, steps_of(frames), mode="RETARGET")


def sit(folder, spacing=SPACING, frames=sitting_figure.FRAMES):
    """The figure sits down on a box and stands up again."""
    shape, figure = figure_body.body(1.0, spacing), sitting_figure.take(frames, 11, GAPS, NOISE)
    moves = sitting_figure.sitting(np.arange(len(figure.clean)) / figure.rate_hz)
    low, high = sitting_figure.SEAT
    return generated(
        folder,
        "Sitting down and standing up",
        "sit",
        shape,
        figure,
        np.array([20, 70, 90, 105, 125, 210, 300, 325, 390]),
        box=(np.array([-0.24, low, 0.0]), np.array([0.24, high, sitting_figure.SEAT_HEIGHT])),
        truth=truth(shape, moves),
    )


GENERATED = {"walk": walk, "walk_short_legs": short_legs, "sit": sit}


def generated(folder, title, stem, shape, figure, shown, **more):
    """The Subject of a figure_body.Body and the walking_figure.Figure that moves it, whose files are written."""
    return Subject(
        title,
        stem,
        shape.vertices,
        shape.quads,
        write(folder / f"{stem}.c3d", figure),
        standing(folder),
        shown,
        planted=planted(shape, figure.contacts),
        **more,
    )


def truth(shape, moves):
    """(f, n, 3): the body where bones have it; moves: (joints, turns, ...)."""
    return figure_body.posed(shape, *moves[:2])


def steps_of(frames):
    """Samples of two steps of the walk."""
    return np.linspace(25, min(frames - 1, 135), 11).round().astype(int)


def write(path, figure):
    """Writes a walking_figure.Figure as C3D, in millimetres; returns the path."""
    path.write_bytes(capture_files.c3d(figure.labels, 1000.0 * figure.positions, rate=figure.rate_hz))
    return path


def standing(folder):
    """The T-pose of the person who was captured."""
    return write(folder / "standing.c3d", walking_figure.t_pose(seed=3, noise=NOISE, frames=5))


def planted(shape, contacts):
    """[(begin, end, vertices of the sole)]: when a foot of the figure stands flat."""
    result = []
    for side in "LR":
        column = figure_body.BONES.index(f"foot.{side}")
        sole = np.flatnonzero((shape.weights[:, column] > 0.95) & (shape.vertices[:, 2] < 0.02))
        flat = np.concatenate([[False], contacts[f"heel.{side}"] & contacts[f"toe.{side}"], [False]])
        ends = np.flatnonzero(np.diff(flat.astype(int)))
        result += [(begin, end, sole) for begin, end in zip(ends[::2], ends[1::2], strict=True)]
    return result
