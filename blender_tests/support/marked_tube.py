# SPDX-License-Identifier: GPL-3.0-or-later
"""A tube and a take made of it: some of its vertices, bent as a whole, a little off the surface."""

import bpy
import numpy as np

from . import meshes, steps, take_files

RINGS, SEGMENTS = 17, 8
HEIGHT = 0.6 * (RINGS - 1)
#: Of the tube: every fourth ring, every other vertex.
MARKED = [ring * SEGMENTS + segment for ring in range(0, RINGS, 4) for segment in range(0, SEGMENTS, 2)]
LABELS = tuple(f"M{vertex}" for vertex in MARKED)
FRAMES = 60
OFF_SKIN = 0.05


def rest_of(obj):
    return np.array([vertex.co for vertex in obj.data.vertices])


def bent(points, share):
    """The tube bent about its foot, by `share` of a third of a turn at its top."""
    angle = share * points[:, 2] / HEIGHT
    result = points.copy()
    result[:, 0] = points[:, 0] * np.cos(angle) + points[:, 2] * np.sin(angle)
    result[:, 2] = points[:, 2] * np.cos(angle) - points[:, 0] * np.sin(angle)
    return result


def recorded():
    """(f, m, 3): markers off the skin of the bending tube. In the first sample it stands as the mesh does."""
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    marked = rest_of(obj)[MARKED]
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    outwards = marked * (1.0, 1.0, 0.0)
    markers = marked + OFF_SKIN * outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    return np.stack([bent(markers, frame / (FRAMES - 1)) for frame in range(FRAMES)])


def set_up(tmp_path, positions=None, align='NONE', **options):
    """(tube, take) with the take chosen."""
    positions = recorded() if positions is None else positions
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    path = take_files.write_trc(tmp_path / "bend.trc", LABELS, positions)
    take = take_files.bring_in(path, unit='METRES', **options)
    capture = obj.meanvalue.capture
    capture.align = align
    capture.reference_frame = 1.0
    assert capture.take == take
    return obj, take


def match():
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}


def at_sample(sample, start=1.0):
    steps.go_to(start + 0.24 * sample)
