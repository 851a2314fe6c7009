# SPDX-License-Identifier: GPL-3.0-or-later
"""Where anchors go. No bpy."""

import numpy as np

from native.benchmarks.rigid import rotation_about


def bent_chord(tip, root, axis, angle_rad):
    """Where the tip (3,) of a rod fixed at `root` goes when the rod bends into an arc and keeps its length.

    The chord turns by `angle_rad` about `axis`, and is shorter than the rod by sin(angle) / angle. A target at
    the full length would ask for a stretch, which swells the mesh: the encoding does not know scale.
    """
    chord = rotation_about(axis, np.degrees(angle_rad)) @ (tip - root)
    return root + np.sinc(angle_rad / np.pi) * chord
