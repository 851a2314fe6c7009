# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes of the tests' own: as TRC files, and imported by the operator."""

import bpy
import numpy as np

from . import capture_files


def write_trc(path, labels, positions, rate_hz=100.0, unit="m"):
    """(f, m, 3) positions with Z up, NaN for what is missing; float32 survives the text. Returns the path as text."""
    path.write_bytes(capture_files.trc(labels, positions, rate=rate_hz, unit=unit, digits=9))
    return str(path)


def waves(frames=120, markers=5, seed=3):
    """(labels, (f, m, 3) float32 positions): points a stride apart that swing, each in its own way."""
    random = np.random.default_rng(seed)
    centre = random.uniform(-1.0, 1.0, (markers, 3)) + np.array([0.0, 0.0, 1.5])
    phase = random.uniform(0.0, 6.0, (markers, 3))
    time = np.arange(frames)[:, None, None] / 30.0
    labels = tuple(f"M{number}" for number in range(markers))
    return labels, (centre + 0.2 * np.sin(time + phase)).astype(np.float32)


def bring_in(path, **options):
    """Imports a file of write_trc(); the collection."""
    before = set(bpy.data.collections)
    options = {"up_axis": 'Z', **options}
    assert bpy.ops.meanvalue.import_motion(filepath=str(path), **options) == {'FINISHED'}
    (made,) = set(bpy.data.collections) - before
    return made


def keys(obj, data_path, index=0):
    """(n, 2) frame and value of the keys of an object's F-curve; none if there is no such curve."""
    curve = curves(obj).find(data_path, index=index)
    return np.array([key.co for key in curve.keyframe_points]).reshape(-1, 2) if curve else np.empty((0, 2))


def curves(obj):
    """The F-curves of an object's action, which has those of several from Blender 4.4 on."""
    action = obj.animation_data.action
    if hasattr(action, "fcurves"):
        return action.fcurves
    return action.layers[0].strips[0].channelbag(obj.animation_data.action_slot).fcurves
