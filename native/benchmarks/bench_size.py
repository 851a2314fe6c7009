# SPDX-License-Identifier: MPL-2.0
"""How binding and dragging grow with the mesh: a generated creature and a real model, at three sizes.

The whole mesh is free but for six patches or nine single vertices; one of them is carried and turned as in bench_drag.
The real model is subdivided, so its sizes are a fourth of each other. Every case runs in a process of its own.

    early   from the beginning of another bind until there is a shape by its coarsest level, which the add-on shows
            until all is bound; and how far from the last settled one, rms
    first   the first solve, from rest
    frame   median of FRAMES solves of a drag
    draft   what the add-on shows while a frame is solved (decision 30): median; how far from the answer, rms; and how
            many of its triangles point against the answer's, which are not flipped there
    settle  the last frame again, to the end of its valley, and how far that leads, rms; the last draft is held against
            this answer too
    peak    most memory that bind took, without the mesh as it is given

--cores tells instead what more cores would give, by Amdahl's law: the serial share of each stage from the fastest of
three runs with one thread and of three with two.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

import meanvalue

from blender_tests.support import mesh_files
from native.benchmarks import drag_cases, generated_creature, reporting, shape_metrics
from native.benchmarks.peers import job as jobs
from native.benchmarks.peers import methods

SIZES = (50_000, 200_000, 1_000_000)
REAL_MODEL, SUBDIVISIONS = "armadillo_14k.obj", (1, 2, 3)
SETUPS = (drag_cases.PATCHES, drag_cases.SINGLE)
FRAMES = 12
STAGES = ("encode", "order", "hierarchy", "coarse level", "factor")
COLUMNS = [
    "model", "vertices", "anchors", "bind s", "CPU s", *STAGES, "early s", "early off", "first s", "frame ms",
    "draft ms", "draft off", "draft flips", "settle s", "settle off", "peak MB", "bytes a vertex",
]  # fmt: skip
TIMES = ("bind s", *STAGES, "first s", "frame ms", "settle s")
CORES = (2, 8, 16, 32)
# Of a bind at a million vertices; its growth is that of 6.2 times from 200,000 to a million.
MOST_EXPONENT, MOST_SECONDS, MOST_PEAK_MB = 1.134, 10.0, 2100.0
MOST_EARLY_SECONDS = 4.0
MOST_DRAFT_MS = {200_000: 25.0, 1_000_000: 130.0}
MOST_OFF = 2e-3


def models(sizes):
    """A Model for each mesh of about these sizes. Skips visibly what isn't there."""
    for size in sizes:
        yield drag_cases.Model("creature", *generated_creature.creature(size), SETUPS)
    path = mesh_files.DATA / "models" / REAL_MODEL
    if not path.is_file():
        reporting.missing(f"the real model, models/{REAL_MODEL}")
        return
    vertices, faces = mesh_files.read_triangles(path)
    for size, _ in zip(SIZES, SUBDIVISIONS, strict=True):
        vertices, faces = subdivided(vertices, faces)
        if size in sizes:
            yield drag_cases.Model(path.stem, vertices, faces, SETUPS)


def subdivided(vertices, faces):
    """Each of m triangles in four, then each vertex half-way to the mean of its neighbours, so that no face is flat."""
    edges = shape_metrics.unique_edges(faces)
    keys = edges[:, 0].astype(np.int64) * len(vertices) + edges[:, 1]
    a, b, c = faces.astype(np.int64).T

    def middle(one, other):
        key = np.minimum(one, other) * len(vertices) + np.maximum(one, other)
        return len(vertices) + np.searchsorted(keys, key)

    ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
    corners = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.concatenate([np.stack(corner, axis=1) for corner in corners]).astype(np.int32)
    points = np.concatenate([vertices, 0.5 * (vertices[edges[:, 0]] + vertices[edges[:, 1]])])
    ends = shape_metrics.unique_edges(finer)
    sums, counts = np.zeros_like(points), np.zeros(len(points))
    for one, other in (ends.T, ends.T[::-1]):
        np.add.at(sums, one, points[other])
        np.add.at(counts, one, 1)
    return 0.5 * (points + sums / np.maximum(counts, 1)[:, None]), finer


def measure(folder, threads):
    """The figures of the job in a folder, by COLUMNS."""
    import resource  # not on Windows, whose tests import this file

    job = jobs.read(folder)
    frames = [jobs.read_targets(folder, step, len(job.anchors)) for step in range(len(job.plan))]
    before, bytes_before = resource.getrusage(resource.RUSAGE_SELF), memory("VmRSS")
    pathlib.Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    began = time.perf_counter()
    deformer = meanvalue.Deformer(job.vertices, job.faces, job.anchors, threads=threads)
    bind = time.perf_counter() - began
    after, peak = resource.getrusage(resource.RUSAGE_SELF), memory("VmHWM") - bytes_before
    report = deformer.report
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    row = {"bind s": bind, "CPU s": cpu, **{stage: report.timings.get(stage, 0.0) for stage in STAGES}}
    drag = deformer.drag()
    seconds, draft_seconds, off, turned = [], [], [], []

    def judge(draft, answer):
        if draft is not None:
            off.append(rms(draft - answer) / job.diagonal)
            turned.append(turned_triangles(draft, answer, job))

    for targets in frames[drag_cases.FRAMES_FROM :]:
        began = time.perf_counter()
        draft = drag.draft(targets)
        draft_seconds.append(time.perf_counter() - began)
        solution = drag.solve(targets)
        seconds.append(solution.timings["total"])
        shape = solution.vertices
        judge(draft, shape)
    settled = drag.solve(targets, settle=True)
    judge(draft, settled.vertices)
    early, early_shape = early_pose(job, targets, threads)
    return {
        **row, "early s": early, "early off": rms(early_shape - settled.vertices) / job.diagonal,
        "first s": seconds[0], "frame ms": 1e3 * statistics.median(seconds[1:]),
        "draft ms": 1e3 * statistics.median(draft_seconds[2:]), "draft off": max(off, default=float("nan")),
        "draft flips": max(turned, default=0), "settle s": settled.timings["total"],
        "settle off": rms(settled.vertices - shape) / job.diagonal,
        "peak MB": peak / 1e6, "bytes a vertex": round(report.bytes / len(job.vertices)),
    }  # fmt: skip


def early_pose(job, targets, threads):
    """(seconds, shape) until there is a shape of a mesh that is being bound."""
    execution = meanvalue.Execution()
    began = time.perf_counter()
    task = meanvalue.start_bind(
        job.vertices, job.faces, job.anchors, threads=threads, early=True, execution=execution
    )  # fmt: skip
    while (early := task.early) is None and not task.wait(0.005):
        pass
    shape = (early or task.result()).solve(targets).vertices
    seconds = time.perf_counter() - began
    execution.cancel()
    return seconds, shape


def memory(name):
    """A figure of this process, in bytes."""
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return 1024 * next(int(line.split()[1]) for line in lines if line.startswith(name + ":"))


def rms(differences):
    """Of n x 3 differences between two shapes."""
    return float(np.sqrt(np.mean(np.square(differences).sum(axis=1))))


def turned_triangles(draft, answer, job):
    """How many of a draft point against the answer's, without those that are flipped in the answer."""
    normals = [shape_metrics.unit_normals(shape, job.faces) for shape in (draft, answer)]
    turned = np.einsum("ij,ij->i", *normals) < 0
    if turned.any():
        turned &= ~shape_metrics.flipped_mask(answer, job.vertices, job.faces)
    return int(turned.sum())


def run(model, setup, threads):
    """One row, measured in another process; None where that fails."""
    with tempfile.TemporaryDirectory() as folder:
        job = drag_cases.job(model, setup, FRAMES)
        jobs.write(job, pathlib.Path(folder))
        command = [sys.executable, __file__, "--case", folder, "--threads", str(threads)]
        done = subprocess.run(command, check=False, capture_output=True, text=True)
    if done.returncode != 0:
        reporting.missing(f"{model.name}, {len(model.vertices):,}, {setup}: {methods.last_line(done.stderr)}")
        return None
    return {"model": model.name, "vertices": len(model.vertices), "anchors": setup, **json.loads(done.stdout)}


def core_rows(model, setup):
    """For each of TIMES: what is serial of it, and how many times as fast it would be on CORES; none if a run fails."""
    runs = {1: [], 2: []}
    for _ in range(3):
        for threads, rows in runs.items():
            row = run(model, setup, threads)
            if row is None:
                return
            rows.append(row)
    for name in TIMES:
        one, two = (min(row[name] for row in rows) for rows in runs.values())
        serial = min(max(2 * two / one - 1, 0.0), 1.0)
        faster = [1 / (serial + (1 - serial) / cores) for cores in CORES]
        yield [model.name, len(model.vertices), setup, name, one, serial, *faster]


def goal_lines(rows):
    """What was reached of the goals."""
    largest = [row for row in rows if row["vertices"] > 0.9 * SIZES[-1]]
    for row in largest:
        name = f"{row['model']}, {row['anchors']}, {row['vertices']:,} vertices"
        yield goal(f"{name}: bind {row['bind s']:.1f} s", row["bind s"], MOST_SECONDS)
        yield goal(f"{name}: peak {row['peak MB']:.0f} MB", row["peak MB"], MOST_PEAK_MB)
        yield goal(f"{name}: early draft {row['early s']:.1f} s", row["early s"], MOST_EARLY_SECONDS)
        for other in rows:
            is_same = (other["model"], other["anchors"]) == (row["model"], row["anchors"])
            if is_same and 0.5 < other["vertices"] / SIZES[1] < 2.0:
                sizes, seconds = zip(*((each["vertices"], each["bind s"]) for each in (other, row)), strict=True)
                exponent = shape_metrics.exponent(sizes, seconds)
                times = seconds[1] / seconds[0]
                yield goal(f"{name}: bind grows {times:.1f} times, exponent {exponent:.2f}", exponent, MOST_EXPONENT)
    for row in rows:
        name = f"{row['model']}, {row['anchors']}, {row['vertices']:,} vertices"
        yield goal(f"{name}: draft {row['draft off']:.1e} off", row["draft off"], MOST_OFF)
        yield goal(f"{name}: {row['draft flips']} triangles of a draft turned over", row["draft flips"], 0)
        for size, most in MOST_DRAFT_MS.items():
            if 0.7 < row["vertices"] / size < 1.4:
                yield goal(f"{name}: draft {row['draft ms']:.1f} ms", row["draft ms"], most)


def goal(text, value, most):
    """A line that tells whether it was reached."""
    return f"{'reached' if value <= most else 'MISSED'}: {text}, at most {most:g}"


def main():
    """Measures, prints, writes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--sizes", default=SIZES, type=lambda text: [int(size) for size in text.split(",")],
                        help="of 50000,200000,1000000 (default: all)")  # fmt: skip
    parser.add_argument("--setups", default=SETUPS, type=lambda text: text.split(","), help="of patches,single")
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--cores", action="store_true", help="only what more cores would give")
    parser.add_argument("--case", type=pathlib.Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.case:
        print(json.dumps(measure(arguments.case, arguments.threads)))
        return
    if arguments.cores:
        cases = [(model, setup) for model in models(arguments.sizes) for setup in arguments.setups]
        columns = ["model", "vertices", "anchors", "stage", "one thread", "serial", *(f"{n} cores" for n in CORES)]
        table = [row for case in cases for row in core_rows(*case)]
        reporting.report("what more cores would give", columns, table, arguments.json)
        return
    rows = []
    for model in models(arguments.sizes):
        for setup in arguments.setups:
            row = run(model, setup, arguments.threads)
            if row:
                rows.append(row)
                print(f"{row['model']}, {row['vertices']:,}, {setup}: bind {row['bind s']:.2f} s", flush=True)
    table = [[row[column] for column in COLUMNS] for row in rows]
    reporting.report("binding and dragging by size", COLUMNS, table, arguments.json)
    print("\n".join(goal_lines(rows)))


if __name__ == "__main__":
    main()
