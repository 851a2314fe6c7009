# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo joints`, and its report."""

import bpy
import numpy as np
from support import bent_tubes

from native.benchmarks import rigid

from . import pictures, pose, report, stage
from .example import limbs
from .example.run import draw_shapes, hold, posed
from .rig import figures
from .rig.run import add_body

ABOUT = ("limbs that bend everywhere, and at the joints of their rigs",)
DESCRIPTION = """\
Bend At: the ends of a figure's arm and leg, of a hind leg and of a finger are moved by the add-on's operators. A
picture of each, bent everywhere and at the rig's joints, and a report."""
OPTIONS = {"engine": "workbench"}

#: The first bone; for each below it where it begins, degrees that it is bent by at rest, and its name.
HIND_LEG = ("thigh", (3.6, 50.0, "lower_leg"), (6.8, -70.0, "hind_foot"))
FINGER = ("finger.01", (4.4, 12.0, "finger.02"), (7.4, 10.0, "finger.03"))
SUBJECTS = {  # how ends are moved, and degrees that they turn about Y; degrees that the camera stands to the right
    "figure": (figures.walker, {"Hand.L": ((-0.28, -0.22, 0.12), 0.0), "Foot.L": ((0.0, -0.25, 0.3), 0.0)}, 65.0),
    "hind leg": (lambda: limb(*HIND_LEG), {"End": ((-2.0, 0.0, 3.2), 25.0)}, 0.0),
    "finger": (lambda: limb(*FINGER), {"End": ((2.4, 0.0, 6.2), -125.0)}, 0.0),
}
#: Of limbs: how thick they are, over what length one bone's weights go over into the next one's; of what is held.
RADIUS, WIDTH, GRIP = 0.6, 1.4, 0.9


def blocks(words, empty_scene):
    """The report's lines; makes the picture."""
    shots, path, rows = [], words.output / "joints.png", []
    for name, (make, moves, azimuth) in SUBJECTS.items():
        empty_scene()
        figure = make()
        obj, _armature = add_body(figure)
        shapes = both(figure, obj, moves)
        picture = stage.Picture(500 if name == "hind leg" else 660, 900, words.samples, words.engine)
        draw_shapes(path, obj, shapes, picture, np.concatenate(shapes), azimuth)
        shots.append(pictures.read_png(path))
        everywhere, at_joints = (off_rest(figure, shape) for shape in shapes)
        rows.append((f"{name}'s bones", f"{everywhere:.2%} off a rigid move everywhere, {at_joints:.2%} at joints"))
    pictures.write_png(path, pictures.side_by_side(shots))
    return [report.block("limbs", [*rows, ("files", path.name)])]


def limb(first, *joints):
    """A figures.Figure of one limb in the plane of X and Z, from its top."""
    straight, faces = bent_tubes.tube(4000, RADIUS)
    heights, angles, names = zip((0.0, 0.0, first), *joints, strict=True)
    turns = [(height, (0.0, 1.0, 0.0), angle) for height, angle in zip(heights[1:], angles[1:], strict=True)]
    top_down = np.concatenate([straight, [(0.0, 0.0, height) for height in (*heights, straight[:, 2].max())]])
    bent = bent_tubes.posed(top_down, turns, WIDTH) * (1.0, -1.0, -1.0)
    vertices, ends = np.split(bent, [len(straight)])
    bones = {name: (ends[i], ends[i + 1], names[i - 1] if i else None) for i, name in enumerate(names)}
    begun = [np.clip((straight[:, 2] - height) / WIDTH + 0.5, 0.0, 1.0) for height in heights[1:]]
    shares = -np.diff([np.ones(len(straight)), *begun, np.zeros(len(straight))], axis=0)
    weights = {name: (np.arange(len(straight)), share) for name, share in zip(names, shares, strict=True)}
    return figures.Figure(vertices, faces, bones, weights, None, ())


def both(figure, obj, moves):
    """[n x 3 bent everywhere, n x 3 bent at joints]; moves: {name of what is held: (offset, degrees)}."""
    first, *_others, last = figure.bones.values()
    holds = {"Top": limbs.near(figure, first[0], GRIP), "End": limbs.near(figure, last[1], GRIP)}
    if "pelvis" in figure.bones:
        holds = {name: each for name, each in limbs.holds(figure).items() if not name.startswith(("Elbow", "Knee"))}
    goal = figure.vertices.copy()
    for name, (offset, degrees) in moves.items():
        held = holds[name]
        centre, turn = goal[held].mean(axis=0), rigid.rotation_about((0.0, 1.0, 0.0), degrees)
        goal[held] = (goal[held] - centre) @ turn.T + centre + offset
    hold(obj, holds, [goal])
    shapes = []
    for obj.meanvalue.bend_at in ('EVERYWHERE', 'RIG'):
        pose.call(bpy.ops.meanvalue.bind)
        shapes.append(posed(obj, 0))
    return shapes


def off_rest(figure, shape):
    """How far bones' skin is off its rest shape, moved rigidly, as a share of its size: root mean square."""
    bones = [indices[weights > 0.95] for indices, weights in figure.weights.values()]
    off = [bent_tubes.rms(shape[each], figure.vertices[each]) for each in bones if len(each)]
    return float(np.sqrt(np.mean(np.square(off))))
