# SPDX-License-Identifier: MPL-2.0
"""The table of methods, and how each is run: ours and the peers, under the same limits."""

import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field

import numpy as np

from native.benchmarks.peers import job as jobs

ROOT = pathlib.Path(__file__).resolve().parents[3]
HERE = pathlib.Path(__file__).resolve().parent
WHEELS = ROOT / "build" / "peers" / "wheels"
CGAL_PROGRAM = ROOT / "build" / "bench" / "cgal_arap"
CGAL_COMPILER = ["g++", "-O2", "-DNDEBUG", "-std=c++17", "-DCGAL_EIGEN3_ENABLED", "-I/usr/include/eigen3"]
# Debian's own Python and Blender, as in ./dev: the module and the peers are installed for those.
PATH = "/usr/bin:/bin"
TIGHT = {"tolerance": 1e-10, "max_iterations": 2000}


@dataclass(frozen=True)
class Method:
    """One row of the tables. program: which process runs it; options: what it is told.

    quality_iterations: to convergence, where it counts iterations; largest: vertices beyond which it is left out.
    """

    name: str
    program: str
    options: dict = field(default_factory=dict)
    quality_iterations: int = 300
    largest: int = 2_000_000
    largest_reason: str = ""

    @property
    def is_ours(self):
        return self.program == "ours"


def our_method(name, handles=False, **keywords):
    """A row of ours; keywords go to meanvalue.Deformer, and with `handles` the rigid pieces go there too."""
    options = {"deformer": keywords, "handles": handles, "tight": TIGHT}
    largest, reason = (15_000, "minutes a solve") if name == "full" else (2_000_000, "")
    return Method(name, "ours", options, largest=largest, largest_reason=reason)


OURS = {
    "fast": our_method("fast", method="fast"),
    "fast, rigidity 0": our_method("fast, rigidity 0", method="fast", rigidity=0.0),
    "fast, handles": our_method("fast, handles", handles=True, method="fast"),
    "paper": our_method("paper", method="paper"),
    "full": our_method("full", method="full"),
}
CGAL = "CGAL spokes and rims"
LIBIGL = "libigl spokes and rims"
PEERS = {
    method.name: method
    for method in (
        Method(CGAL, "cgal", {"variant": "spokes_and_rims"}),
        Method("CGAL SRE", "cgal", {"variant": "sre"}, largest=300_000, largest_reason="like CGAL, but slower"),
        Method(LIBIGL, "libigl", {"energy": "ARAP_ENERGY_TYPE_SPOKES_AND_RIMS"}),
        Method("libigl spokes", "libigl", {"energy": "ARAP_ENERGY_TYPE_SPOKES"}),
        Method("rotation-invariant", "baseline", {"baseline": "rotation_invariant"}, 1, 60_000,
               "binds for each update"),
        Method("Open3D", "open3d", {"energy": "Spokes"}, 100, 60_000, "half a minute an update"),
        Method("Blender Laplacian Deform", "blender", {}, 10, 60_000,
               "bind takes minutes; its manual warns from 100,000"),
    )
}  # fmt: skip


@dataclass
class Outcome:
    """What a run gave, or why it gave nothing: `missing` is then a reason. shapes: (kept, n, 3)."""

    method: Method
    missing: str = ""
    result: dict = field(default_factory=dict)
    shapes: np.ndarray | None = None


def run(method, job, iterations, time_limit, **options):
    """Runs a job in a process of its own. iterations: for those that count them; time_limit: seconds for everything."""
    if len(job.vertices) > method.largest:
        return Outcome(method, f"left out at this size: {method.largest_reason}")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        own = {"iterations": iterations, **method.options, **options}
        jobs.write(jobs.Job(**{**vars(job), "options": {**job.options, **own}}), folder)
        try:
            command = COMMANDS[method.program](method, folder, {**job.options, **own})
        except (subprocess.CalledProcessError, FileNotFoundError) as error:
            return Outcome(method, last_line(getattr(error, "stderr", "") or str(error)))
        return finish(method, command, folder, len(job.vertices), time_limit)


def finish(method, command, folder, vertex_count, time_limit):
    """Waits for the process and reads what it left."""
    try:
        done = subprocess.run(
            command, env=environment(), capture_output=True, text=True, timeout=time_limit, check=False
        )
    except FileNotFoundError:
        return Outcome(method, f"{command[0]} is not installed")
    except subprocess.TimeoutExpired:
        return Outcome(method, f"not done within {time_limit:g} s")
    if done.returncode != 0 or not (folder / "result.json").exists():
        return Outcome(method, last_line(done.stderr) or last_line(done.stdout) or f"ended with {done.returncode}")
    result, shapes = jobs.read_result(folder, vertex_count)
    if not np.isfinite(shapes).all():
        return Outcome(method, "gave positions that are not numbers", result)
    return Outcome(method, "", result, shapes)


def environment():
    """For every process: Debian's programs first, the peers' wheels, no display."""
    python_path = [os.environ.get("PYTHONPATH", ""), str(WHEELS)]
    return {**os.environ, "PATH": PATH, "PYTHONPATH": ":".join(filter(None, python_path))}


def last_line(text):
    """Of what a program printed: where the reason mostly is."""
    lines = [line.strip() for line in text.splitlines() if line.strip() and "EGL" not in line]
    return lines[-1][:160] if lines else ""


def build_cgal():
    """Compiles cgal_arap.cpp where the program is missing or older."""
    source = HERE / "cgal_arap.cpp"
    if not pathlib.Path("/usr/include/CGAL/Surface_mesh_deformation.h").exists():
        raise FileNotFoundError("CGAL's headers are not installed (libcgal-dev)")
    if not CGAL_PROGRAM.exists() or CGAL_PROGRAM.stat().st_mtime < source.stat().st_mtime:
        CGAL_PROGRAM.parent.mkdir(parents=True, exist_ok=True)
        made = CGAL_PROGRAM.with_suffix(".new")
        command = [*CGAL_COMPILER, str(source), "-o", str(made), "-lmpfr", "-lgmp"]
        subprocess.run(command, check=True, capture_output=True, text=True)
        made.replace(CGAL_PROGRAM)
    return str(CGAL_PROGRAM)


def build_cgal_quietly():
    """Before several runs want it at once; what is wrong is told by those."""
    with contextlib.suppress(subprocess.CalledProcessError, FileNotFoundError):
        build_cgal()


def cgal_command(method, folder, options):
    limits = [options["iterations"], options.get("frame_seconds", 1e9), options.get("least_steps", 1)]
    return [build_cgal(), method.options["variant"], str(folder), *map(str, limits)]


def python_command(method, folder, options):
    return [sys.executable, str(HERE / f"run_{method.program}.py"), str(folder)]


def blender_command(method, folder, options):
    script = str(HERE / "run_blender.py")
    return ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python", script, "--",
            str(folder)]  # fmt: skip


COMMANDS = {
    "ours": python_command, "baseline": python_command, "libigl": python_command, "open3d": python_command,
    "cgal": cgal_command, "blender": blender_command,
}  # fmt: skip


def self_intersections(vertices, faces, shapes):
    """Pairs of triangles that intersect in each of the shapes (s, n, 3), by CGAL; Nones without it."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for array, kind, file in ((vertices, np.float64, "vertices"), (faces, np.int32, "faces"),
                                  (shapes, np.float64, "shapes")):  # fmt: skip
            np.ascontiguousarray(array, kind).tofile(folder / f"{file}.bin")
        try:
            command = [build_cgal(), "intersections", str(folder)]
            done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment())
        except (subprocess.CalledProcessError, FileNotFoundError):
            return [None] * len(shapes)
        return [int(line) for line in done.stdout.split()]
