# SPDX-License-Identifier: MPL-2.0
"""A job, a list of solves on one bound mesh, as a folder of raw arrays that programs in any language can read.

    job.json       counts, options, and `frame_seconds`: no further step is begun when the steps took that long
    vertices.bin   (n, 3) float64        faces.bin   (m, 3) int32
    anchors.bin    (k,) int32            pieces.bin  (k,) int32: anchors of one piece move rigidly together; -1: fixed
    targets.bin    (s, k, 3) float64, read one step at a time so that they do not count as the method's memory
    plan.bin       (s,) int32, the sum of RESTART (start from the rest shape) and KEEP (the result is wanted)

The result is result.json (bind_seconds, seconds and cpu_seconds of the steps done, peak_bytes) and shapes.bin, the
(n, 3) float64 positions of the steps to keep, in their order.
"""

import json
from dataclasses import dataclass, field

import numpy as np

RESTART, KEEP = 1, 2


@dataclass
class Job:
    """vertices (n, 3), faces (m, 3), anchors (k,), pieces (k,), targets (s, k, 3), plan (s,); see the module."""

    vertices: np.ndarray
    faces: np.ndarray
    anchors: np.ndarray
    pieces: np.ndarray
    targets: np.ndarray
    plan: np.ndarray
    options: dict = field(default_factory=dict)

    @property
    def diagonal(self):
        """Of the rest shape's bounding box."""
        return float(np.linalg.norm(np.ptp(self.vertices, axis=0)))


def write(job, folder):
    """Fills `folder`, which is made where it is missing."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, kind in (("vertices", np.float64), ("targets", np.float64), ("faces", np.int32), ("anchors", np.int32),
                       ("pieces", np.int32), ("plan", np.int32)):  # fmt: skip
        np.ascontiguousarray(getattr(job, name), kind).tofile(folder / f"{name}.bin")
    counts = {"vertices": len(job.vertices), "faces": len(job.faces), "anchors": len(job.anchors)}
    (folder / "job.json").write_text(json.dumps({**counts, "steps": len(job.plan), **job.options}))


def read(folder):
    """The job without its targets: those are None; read_targets() gives them one step at a time."""
    options = json.loads((folder / "job.json").read_text())
    return Job(
        np.fromfile(folder / "vertices.bin").reshape(-1, 3), np.fromfile(folder / "faces.bin", np.int32).reshape(-1, 3),
        np.fromfile(folder / "anchors.bin", np.int32), np.fromfile(folder / "pieces.bin", np.int32), None,
        np.fromfile(folder / "plan.bin", np.int32), options,
    )  # fmt: skip


def read_targets(folder, step, anchor_count):
    """(k, 3) targets of one step."""
    values = 3 * anchor_count
    return np.fromfile(folder / "targets.bin", count=values, offset=step * values * 8).reshape(-1, 3)


def write_result(folder, result, shapes):
    """result: a dictionary; shapes: the (n, 3) positions kept."""
    with (folder / "shapes.bin").open("wb") as file:
        for shape in shapes:
            np.ascontiguousarray(shape, np.float64).tofile(file)
    (folder / "result.json").write_text(json.dumps(result))


def read_result(folder, vertex_count):
    """(result dictionary, (kept, n, 3) shapes)."""
    return json.loads((folder / "result.json").read_text()), np.fromfile(folder / "shapes.bin").reshape(
        -1, vertex_count, 3
    )
