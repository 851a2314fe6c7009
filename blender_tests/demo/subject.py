# SPDX-License-Identifier: GPL-3.0-or-later
"""What every demo poses and photographs: one object, its anchors, their targets, and the view."""

from dataclasses import dataclass

import numpy as np

from native.benchmarks.rigid import rotation_about


@dataclass(frozen=True)
class View:
    """Camera direction in degrees (stage.camera_axes) and picture size in pixels."""

    azimuth_deg: float = 20.0
    elevation_deg: float = 18.0
    width: int = 960
    height: int = 720


@dataclass(frozen=True)
class Subject:
    """A mesh object ready to be posed.

    targets: (n, 3) positions in object space of which only the anchors' count.
    grab: (vertex, how far it is moved in the world (3,), Size) to take hold of the mesh by, in place of all these.
    companions: other objects on its rig.
    """

    title: str
    file_stem: str
    obj: object
    handles: tuple = ()
    roi_group: str = ""
    targets: np.ndarray = None
    view: View = View()
    grab: tuple = None
    companions: tuple = ()


def bent_chord(tip, root, axis, angle_rad):
    """Where the tip (3,) of a rod fixed at `root` goes when the rod bends into an arc and keeps its length.

    The chord turns by `angle_rad` about `axis`, and is shorter than the rod by sin(angle) / angle. A target at
    the full length would ask for a stretch, which swells the mesh: the encoding does not know scale.
    """
    chord = rotation_about(axis, np.degrees(angle_rad)) @ (tip - root)
    return root + np.sinc(angle_rad / np.pi) * chord
