# SPDX-License-Identifier: GPL-3.0-or-later
"""Real captures on real bodies, from the shared data beside the checkout: looked at, never kept. No bpy."""

import numpy as np
from support import mesh_files

from .subjects import Subject

TAKES = {
    "pig": ("mocap/pig-walk/PiG_Motion-FlatFoot-One.c3d", "mocap/pig-walk/PiG_Calibration-FlatFoot-One.c3d"),
    "rajagopal": ("mocap/rajagopal/motion_capture_walk.trc", "mocap/rajagopal/static_walk_1.trc"),
}
#: file, metres for its unit, and how many of its first vertices are the body.
BODIES = {"man": ("models/human_man.obj", 1.0, None), "makehuman": ("makehuman/base.obj", 0.1, 13380)}


def subject(body, take):
    """A Subject of a body and a take."""
    path, unit, count = BODIES[body]
    vertices, polygons = mesh_files.read_obj(mesh_files.DATA / path)
    if count is not None:
        polygons = [polygon for polygon in polygons if max(polygon) < count]
        vertices = vertices[:count]
    upright = unit * np.stack([vertices[:, 0], -vertices[:, 2], vertices[:, 1]], axis=1)
    upright[:, 2] -= upright[:, 2].min()
    motion, standing = (mesh_files.DATA / name for name in TAKES[take])
    return Subject(f"{take} on {body}", f"{take}_{body}", upright, polygons, motion, standing, np.arange(40, 161, 12))


MAKERS = {
    f"{take} on {body}": (lambda _folder, body=body, take=take: subject(body, take))
    for take in TAKES
    for body in BODIES
}


def missing(title):
    """The first file that is needed for it and is not there, or None."""
    take, _, body = title.partition(" on ")
    names = (BODIES[body][0], *TAKES[take])
    return next((mesh_files.DATA / name for name in names if not (mesh_files.DATA / name).is_file()), None)
