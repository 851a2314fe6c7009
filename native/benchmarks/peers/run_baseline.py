# SPDX-License-Identifier: MPL-2.0
"""Process for the methods of meanvalue.baselines. Arguments: the job's folder. They bind anew at each step."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3]))

import meanvalue

from native.benchmarks.peers import worker


def bind(job):
    """step(targets, restart) -> positions."""
    function = getattr(meanvalue.baselines, job.options["baseline"])
    return lambda targets, restart: function(job.vertices, job.faces, job.anchors, targets)


if __name__ == "__main__":
    worker.serve(sys.argv[1], bind)
