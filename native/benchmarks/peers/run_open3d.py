# SPDX-License-Identifier: MPL-2.0
"""Process for Open3D's ARAP. Arguments: the job's folder. Options: `iterations`, `energy`, "Spokes" or "Smoothed".

One call factors and solves from the rest shape, so there is no bind and no warm start.
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))

import open3d

from native.benchmarks.peers import worker


class Steps:
    """Every step from the rest shape."""

    def __init__(self, job):
        triangles = open3d.utility.Vector3iVector(job.faces)
        self.mesh = open3d.geometry.TriangleMesh(open3d.utility.Vector3dVector(job.vertices), triangles)
        self.anchors = open3d.utility.IntVector(job.anchors)
        self.iterations = job.options["iterations"]
        self.energy = getattr(open3d.geometry.DeformAsRigidAsPossibleEnergy, job.options["energy"])

    def __call__(self, targets, restart):
        moved = self.mesh.deform_as_rigid_as_possible(
            self.anchors, open3d.utility.Vector3dVector(targets), max_iter=self.iterations, energy=self.energy
        )
        return np.asarray(moved.vertices)


if __name__ == "__main__":
    worker.serve(sys.argv[1], Steps)
