# SPDX-License-Identifier: MPL-2.0
"""Process for libigl's ARAP. Arguments: the job's folder. Options: `energy` (name in ARAPEnergyType), `iterations`."""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))

import igl

from native.benchmarks.peers import worker


class Steps:
    """The global step is factored once; every step goes on from the last answer."""

    def __init__(self, job):
        self.rest = np.ascontiguousarray(job.vertices)
        self.data = igl.ARAPData()
        self.data.max_iter = job.options["iterations"]
        self.data.energy = getattr(igl.ARAPEnergyType, job.options["energy"])
        igl.arap_precomputation(self.rest, job.faces.astype(np.int64), 3, job.anchors.astype(np.int32), self.data)
        self.last = self.rest

    def __call__(self, targets, restart):
        self.last = igl.arap_solve(targets, self.data, self.rest if restart else self.last)
        return self.last


if __name__ == "__main__":
    worker.serve(sys.argv[1], Steps)
