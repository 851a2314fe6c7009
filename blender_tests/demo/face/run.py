# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line of `./dev demo face`, and its report."""

import time

import bpy
import numpy as np
from support import faces, marked_face

from .. import markers, pictures, pose, report, scene_mesh, stage
from . import plot

FRAMES, SHOWN = 90, (1, 18, 34, 50, 66, 82)

#: {name: noise of a marker in metres}
NOISES = {"clean": 0.0, "noisy": 0.0002}

#: Of the samples of a marker.
GAPS = 0.08

SKIN, LIPS = np.array([0.62, 0.42, 0.33]), np.array([0.55, 0.16, 0.15])
ABOUT = (
    "values of shape keys from markers",
    "Errors are of values that go from 0 to 1, over all frames and keys. The head turns by 20 degrees meanwhile.",
)
DESCRIPTION = """\
A generated head with a dozen shape keys and a generated capture of 60 markers with noise and gaps, in a space of its
own: markers are matched by four picked pairs, and the values are baked, by the add-on's operators. A plot of the values
beside the truth, a film strip of the face with the recorded markers, the .blend files and a report."""
OPTIONS = {"subjects": NOISES, "only": "just one of the captures"}


def blocks(words, empty_scene):
    """The report's lines for each capture; makes the files."""
    return [one(name, words, empty_scene) for name in NOISES if words.only in (None, name)]


def one(name, words, empty_scene):
    """Bakes, measures and draws one capture; returns its lines of the report."""
    empty_scene()
    print(f"{name}: baking ...", flush=True)
    obj, truth = marked_face.make(), faces.values(FRAMES)
    scene_mesh.shade_smooth(obj)
    scene_mesh.set_vertex_colours(obj, colours(faces.rest()[0]))
    obj.data.materials.append(scene_mesh.tinted_material("Skin", tuple(SKIN), 0.45))
    damage = {"noise": NOISES[name], "gaps": GAPS if NOISES[name] else 0.0}
    vertices = marked_face.captured(words.output / f"face_{name}.trc", obj, truth, **damage)
    marked_face.pick(vertices)
    began = time.perf_counter()
    pose.call(bpy.ops.meanvalue.bake_values, source='MARKERS', head_motion='OBJECT')
    seconds = time.perf_counter() - began
    frames = range(1, FRAMES + 1)
    found = marked_face.keyed(obj, frames)
    plot.write(words.output / f"face_{name}.svg", faces.KEYS, truth, found)
    bpy.ops.wm.save_as_mainfile(filepath=str(words.output / f"face_{name}.blend"), check_existing=False)
    draw(words.output / f"face_{name}.png", obj, faces.recorded(truth, vertices, **damage), words)
    off = np.abs(found - truth)
    rows = [
        ("markers, keys, frames", f"{len(vertices)}, {len(faces.KEYS)}, {FRAMES}"),
        ("noise, gaps", f"{1000.0 * damage['noise']:g} mm, {damage['gaps']:.0%}"),
        (
            "error of a value",
            f"{off.mean():.4f} on average, {np.quantile(off, 0.95):.3f} in 95 %, {off.max():.3f} at most",
        ),
        ("seconds", f"{seconds:.2f}"),
        ("files", ", ".join(f"face_{name}.{suffix}" for suffix in ("png", "svg", "trc", "blend"))),
    ]
    return report.block(f"a face, {name}", rows)


def draw(path, obj, recorded, words):
    """The face as its values and its motion have it, with the markers as recorded, frame by frame."""
    for each in bpy.data.objects:
        each.hide_render = each != obj
    strip = []
    points = np.concatenate([faces.rest()[0], 1.15 * faces.rest()[0]])
    stage.set_stage(points, stage.Picture(330, 420, words.samples, words.engine), 5.0, 4.0, margin=0.04)
    for frame in SHOWN:
        bpy.context.scene.frame_set(frame)
        seen = recorded[frame - 1][np.isfinite(recorded[frame - 1, :, 0])]
        spheres = markers.add_spheres("Markers", seen, 0.0025, markers.ANCHOR_COLOUR)
        strip.append(stage.render(path))
        bpy.data.objects.remove(spheres)
    pictures.write_png(path, pictures.side_by_side(strip))


def colours(points):
    """(n, 3) of points on the head: lips and eyes are dark."""
    lips = faces.near(points, (0.0, -1.0, -0.42), 0.016)[:, None]
    eyes = sum(faces.near(points, (side, -0.95, 0.2), 0.011) for side in (0.4, -0.4))[:, None]
    colours = SKIN + np.minimum(1.2 * lips, 1.0) * (LIPS - SKIN)
    return colours * (1.0 - 0.9 * np.minimum(eyes, 1.0))
