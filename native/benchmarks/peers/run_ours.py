# SPDX-License-Identifier: MPL-2.0
"""Process for our methods. Arguments: the job's folder.

Options of the job: `deformer`, keyword arguments; `handles`, whether the pieces are given to it; `tight`, keyword
arguments of a solve to tight tolerance; `check`, numbers of the steps that are compared with such solves;
`beside_cold`, whether the last step done is compared with a solve of its targets from rest, no tighter than itself.
"""

import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))

import meanvalue

from native.benchmarks.peers import worker


class Steps:
    """Solves from the last answer; remembers those that are to be checked."""

    def __init__(self, job):
        self.options, self.vertices, self.diagonal = job.options, job.vertices, job.diagonal
        keywords = dict(job.options["deformer"])
        if job.options.get("handles"):
            keywords["handles"] = piece_numbers(job.pieces)
        self.deformer = meanvalue.Deformer(job.vertices, job.faces, job.anchors, **keywords)
        self.drag, self.last, self.last_targets, self.number = None, None, None, 0
        self.remembered, self.solutions = {}, {"iterations": [], "energies": [], "converged": []}

    def __call__(self, targets, restart):
        if restart or self.drag is None:
            self.drag = self.deformer.drag()
        solution = self.drag.solve(targets)
        self.last, self.last_targets = solution.vertices, targets
        if self.number in self.options.get("check", []):
            self.remembered[self.number] = (targets, np.array(self.last))
        self.solutions["iterations"].append(int(solution.iterations))
        self.solutions["energies"].append(float(solution.energy))
        self.solutions["converged"].append(bool(solution.converged))
        self.number += 1
        return self.last

    def after(self):
        """Distances over the diagonal from the steps' answers to solves to tight tolerance.

        `onwards` starts from the answer: has it converged? `afresh` starts from rest: does the way there matter?
        """
        checks = {}
        for number, (targets, answer) in self.remembered.items():
            onwards = self.deformer.solve(targets, start=answer, **self.options["tight"]).vertices
            afresh = self.deformer.solve(targets, **self.options["tight"]).vertices
            checks[number] = {
                name: float(np.linalg.norm(other - answer, axis=1).max() / self.diagonal)
                for name, other in (("onwards", onwards), ("afresh", afresh))
            }
        found = {"checks": checks, "unconverged": self.solutions["converged"].count(False), **self.solutions}
        if self.options.get("beside_cold"):
            cold = self.deformer.solve(self.last_targets)
            found["cold_energy"] = float(cold.energy)
            found["cold_distance"] = float(np.linalg.norm(cold.vertices - self.last, axis=1).max() / self.diagonal)
        return found


def piece_numbers(pieces):
    """Pieces from 0; the fixed anchors, -1 in a job, are one piece that stays."""
    return (pieces + 1 if (pieces < 0).any() else pieces).astype(np.int32)


if __name__ == "__main__":
    worker.serve(sys.argv[1], Steps)
