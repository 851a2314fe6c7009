# SPDX-License-Identifier: MPL-2.0
"""The sparse Cholesky factorisation: seconds of its stages, fill and speed, on generated grids and on real meshes."""

import json
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from blender_tests.support import mesh_files
from native.benchmarks import reporting

ROOT = pathlib.Path(__file__).resolve().parents[2]

BUILD = ROOT / "build" / "native"
MODELS = mesh_files.DATA / "models"
GRIDS = [(100, 1), (224, 1), (447, 1), (1000, 1), (46, 3), (103, 3), (145, 3)]
FILES = ["feline.off", "horse.off", "beast_quads.obj"]
COLUMNS = [
    "mesh", "unknowns", "order s", "analyse s", "factor s", "factor again s", "solve s", "numbers a column",
    "GFlop/s", "residual",
]  # fmt: skip


def measure(mesh, block):
    """One row of the table. mesh: the side of a grid, or a file; block: unknowns a vertex."""
    program = BUILD / "native" / "meanvalue_factor_benchmark"
    threads = len(os.sched_getaffinity(0))
    done = subprocess.run(
        [program, str(mesh), str(block), str(threads)], capture_output=True, text=True, check=True
    )  # fmt: skip
    found = json.loads(done.stdout)
    name = f"{pathlib.Path(str(mesh)).stem}{' x 3' if block == 3 else ''}"
    keys = ["unknowns", "order", "analyse", "factor", "again", "solve", "numbers", "gflops", "residual"]
    return [name, *(found[key] for key in keys)]


def main():
    json_path = reporting.json_argument(__doc__)
    subprocess.run(["cmake", "--build", BUILD, "--target", "meanvalue_factor_benchmark"], check=True, stdout=2)
    rows = [measure(side, block) for side, block in GRIDS]
    for name in FILES:
        if (MODELS / name).exists():
            rows.append(measure(MODELS / name, 1))
        else:
            reporting.missing(f"models/{name}")
    reporting.report("Sparse Cholesky factorisation", COLUMNS, rows, json_path)


if __name__ == "__main__":
    main()
