# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands of a render farm: plan, bake, merge, status. Only plan needs Blender and the scene.

    OUT/plan/plan.json            what there is to do, with versions; tasks.tsv and clips.tsv, a line for each index
    OUT/plan/CLIP.npz             all that the frames of a clip depend on
    OUT/CLIP/chunks/              chunks and their markers (core.chunk_store)
    OUT/CLIP/CLIP.pc2             the point cache, and its report

Exit codes: 0 done, or done before; 1 failed; 2 bad arguments; 3 frames are missing; 4 a chunk is damaged (and was taken
out, so that it is missing now).
"""

import argparse
import os
import pathlib
import sys
import time

from ...errors import DamagedCacheError, IncompleteCacheError, MeanValueError, SceneError
from ...scene.core import whole_files
from ...scene.core.checked_json import read_checked_json, read_json, write_checked_json
from ...solver import native_loader, session
from ...solver.core.fingerprint import digest
from ...solver.core.steps import result_of
from ...solver.job import Job
from ..core import frame_ranges, point_cache
from ..core.bake_report import BakeReport
from ..core.chunk_store import ChunkStore
from . import baking, bundle

SCHEMA = 2
DONE, FAILED, BAD_ARGUMENTS, INCOMPLETE, DAMAGED = range(5)

#: How often a line of progress is printed.
PROGRESS_SECONDS = 0.5


def main(arguments):
    """Returns the exit code."""
    options = _parser().parse_args(arguments)
    _say(f"Mean-Value Deform farm: {options.command}, solver {native_loader.module().__version__}")
    try:
        return options.run(options)
    except DamagedCacheError as error:
        return _failed(error, DAMAGED)
    except IncompleteCacheError as error:
        return _failed(error, INCOMPLETE)
    except SceneError as error:
        return _failed(error, BAD_ARGUMENTS)
    except MeanValueError as error:
        return _failed(error, FAILED)


def write_plan(out, clips, chunk):
    """Freezes what there is to do. Returns how many tasks and clips. @throws CacheError.

    clips: [(name, BakePlan, triangles)]; chunk: frames of a task.
    """
    folder = pathlib.Path(out, "plan")
    listed, tasks = [], []
    for name, plan, triangles in clips:
        sha256 = bundle.save(folder / f"{name}.npz", plan, triangles)
        frames = list(plan.numbers)
        parts = [frame_ranges.spelled(frames[begin : begin + chunk]) for begin in range(0, len(frames), chunk)]
        spelled = frame_ranges.spelled(frames)
        listed.append({"name": name, "key": plan.key, "sha256": sha256, "frames": spelled, "chunks": parts})
        tasks += [f"{name}\t{part}\n" for part in parts]
    _write_text(folder / "tasks.tsv", "".join(tasks))
    _write_text(folder / "clips.tsv", "".join(f"{clip['name']}\t{clip['frames']}\n" for clip in listed))
    key = digest(*(clip["key"] for clip in listed))
    content = {"schema": SCHEMA, "key": key, "clips": listed, "versions": _versions()}
    write_checked_json(folder / "plan.json", content)
    return len(tasks), len(listed)


def _run_plan(options):
    from . import farm_scene  # Blender is needed for nothing else

    clips = farm_scene.planned(options.clip, options.frames, options.portable)
    tasks, count = write_plan(options.out, clips, options.chunk)
    _say(f"planned {tasks} tasks (indices 0 to {tasks - 1}) of {count} clips (0 to {count - 1}) in {options.out}/plan")
    return DONE


def _run_bake(options):
    out, clip, frames = task_of(options, "tasks.tsv")
    plan, triangles = _load(out, clip)
    _require_key(plan, clip["key"])
    store = _store(out, clip, plan, frames)
    if store.has(frames):
        _say(f"{clip['name']} {frame_ranges.spelled(frames)}: done before")
        return DONE
    numbers = list(plan.numbers)
    begun = time.monotonic()
    for first, last in frame_ranges.runs(frames):
        rows = numbers.index(first), numbers.index(last) + 1
        own = list(range(first, last + 1))
        if not store.has(own):
            solved = _solve(plan, triangles, rows, options.threads)
            store.write(own, solved.vertices, solved.report)
    _say(f"{clip['name']} {frame_ranges.spelled(frames)}: {len(frames)} frames in {time.monotonic() - begun:.1f} s")
    return DONE


def _run_merge(options):
    out, clip, frames = task_of(options, "clips.tsv")
    if len(frame_ranges.runs(frames)) != 1:
        raise SceneError(f"A point cache has no gaps, but {frame_ranges.spelled(frames)} has. Merge one range")
    plan, _triangles = _load(out, clip)
    _require_key(plan, clip["key"])
    path = out / clip["name"] / f"{clip['name']}.pc2"
    header = point_cache.Header(plan.vertices, float(frames[0]), plan.spacing, len(frames))
    key = f"{plan.key} {frame_ranges.spelled(frames)}"
    marker = read_json(baking.report_path(path))
    if marker is not None and marker.get("key") == key and path.exists() and path.stat().st_size == header.bytes:
        _say(f"{path}: done before")
        return DONE
    for begun in (out / clip["name"] / "chunks").glob("*.pc2"):
        whole_files.remove_abandoned(begun)
    steps = _store(out, clip, plan, frames).merge(path, header)
    columns = result_of(steps)
    report = BakeReport.of(frames, columns)
    baking.write_report(path, report, {"key": key, "clip": clip["name"]})
    _say(f"{path}: {report.text()}")
    for note in report.notes():
        _say(f"warning: {note}")
    return DONE


def _run_status(options):
    out = pathlib.Path(options.out)
    plan = read_plan(out / "plan")
    missing, index = [], 0
    for clip in plan["clips"]:
        vertices = _load(out, clip)[0].vertices
        store = ChunkStore(out / clip["name"] / "chunks", clip["key"], frame_ranges.parse(clip["frames"]), vertices)
        there = set(store.frames) - set(store.missing())
        for part in clip["chunks"]:
            if not there.issuperset(frame_ranges.parse(part)):
                missing.append(index)
            index += 1
        if not options.missing:
            is_merged = (out / clip["name"] / f"{clip['name']}.pc2").exists()
            merged = "merged" if is_merged else "not merged"
            print(f"{clip['name']}: {len(there)} of {len(store.frames)} frames, {merged}", flush=True)
    if options.missing:
        print(frame_ranges.spelled(missing), flush=True)
    else:
        print(f"{index - len(missing)} of {index} tasks are done", flush=True)
    return DONE


def _solve(plan, triangles, rows, threads):
    def work(execution):
        binding = session.cached(plan.bind_input, plan.portable)
        if binding is None:
            binding = yield from session.bind_steps(plan.bind_input, triangles, execution, plan.portable)
            session.remember(plan.bind_input, binding, plan.portable)
        return (yield from plan.solve_rows(binding, *rows, execution, threads))

    job, begun, told = Job(work), time.monotonic(), 0
    count = rows[1] - rows[0]
    while not job.wait(PROGRESS_SECONDS):
        stage, share = job.progress
        solved = int(share * count) if stage == "solve" else 0
        told = _tell_progress(told, solved, count, begun)
    result = job.result()
    _tell_progress(told, count, count, begun)
    return result


def _tell_progress(told, solved, count, begun):
    """One line for each frame, as Flamenco counts them, and the share as OpenJD takes it."""
    minutes, seconds = divmod(time.monotonic() - begun, 60.0)
    for _ in range(told, solved):
        print(f"Time: {minutes:02.0f}:{seconds:05.2f}")
    if solved > told:
        print(f"openjd_progress: {100.0 * solved / count:.1f}", flush=True)
    return max(told, solved)


def _load(out, clip):
    return bundle.load(out / "plan" / f"{clip['name']}.npz", clip["sha256"])


def task_of(options, table):
    """(OUT, clip of plan.json, frames): by --plan and --index, or by --out, --clip, --frames and --key."""
    if options.index is not None:
        if options.plan is None:
            raise SceneError("--index needs --plan")
        folder = pathlib.Path(options.plan)
        plan = read_plan(folder)
        with whole_files.telling(folder / table):
            lines = (folder / table).read_text(encoding="utf-8", errors="replace").splitlines()
        if not 0 <= options.index < len(lines):
            raise SceneError(f"There is no line {options.index} in {folder / table}: it has 0 to {len(lines) - 1}")
        name, _, text = lines[options.index].partition("\t")
    else:
        if options.out is None or options.clip is None or options.frames is None:
            raise SceneError("Give --plan and --index, or --out, --clip, --frames and --key")
        folder, name, text = pathlib.Path(options.out, "plan"), options.clip, options.frames
        plan = read_plan(folder)
    clip = next((clip for clip in plan["clips"] if clip["name"] == name), None)
    if clip is None:
        raise SceneError(f"There is no clip '{name}' in {folder / 'plan.json'}")
    if options.key is not None and options.key != clip["key"]:
        raise SceneError(f"The key of '{name}' is {clip['key']} in {folder / 'plan.json'}, not {options.key}")
    frames = frame_ranges.parse(text)
    outside = sorted(set(frames) - set(frame_ranges.parse(clip["frames"])))
    if outside:
        raise SceneError(f"Frames {frame_ranges.spelled(outside)} are not in '{name}', {clip['frames']}")
    return folder.parent, clip, frames


def read_plan(folder):
    plan = read_checked_json(folder / "plan.json")
    if plan is None or plan.get("schema") != SCHEMA:
        raise SceneError(f"There is no plan in {folder}, or it is damaged. Run plan first, with the same --out")
    return plan


def _require_key(plan, key):
    """The solver is part of the key. @throws MeanValueError."""
    if plan.key != key:
        raise MeanValueError(
            f"The plan was made for other inputs or another solver (key {key}, here {plan.key}; solver "
            f"{_versions()['solver']} here). Install the same add-on on all machines, or plan again"
        )


def _store(out, clip, plan, frames):
    return ChunkStore(out / clip["name"] / "chunks", plan.key, frames, plan.vertices)


def _versions():
    return {"solver": native_loader.module().__version__, **dict(native_loader.environment())}


def _write_text(path, text):
    with whole_files.replacing(path) as file:
        file.write(text.encode())


def _say(text):
    print(f"meanvalue: {text}", flush=True)


def _failed(error, code):
    print(f"openjd_fail: {error}\nmeanvalue: error: {error}", file=sys.stderr, flush=True)
    return code


def _parser():
    parser = argparse.ArgumentParser(prog="meanvalue_farm.py", description="Bakes animated handles on many machines.")
    commands = parser.add_subparsers(dest="command", required=True)
    plan = commands.add_parser("plan", help="freeze the inputs (in Blender, with the scene)")
    plan.add_argument("--out", required=True)
    plan.add_argument("--chunk", type=_positive, default=200, help="frames of a task")
    plan.add_argument("--clip", action="append", help="NAME, NAME=OBJECT or NAME=OBJECT:FRAMES; default: all")
    plan.add_argument("--frames", help="of clips that say nothing else; the scene's range if left out")
    plan.add_argument("--portable", action="store_true", help="the same bits on processors of different kinds; slower")
    plan.set_defaults(run=_run_plan)
    for name, run in (("bake", _run_bake), ("merge", _run_merge)):
        command = commands.add_parser(name)
        command.add_argument("--plan", help="OUT/plan")
        command.add_argument("--index", type=int, help="line of tasks.tsv (bake) or clips.tsv (merge), from 0")
        command.add_argument("--out")
        command.add_argument("--clip")
        command.add_argument("--frames")
        command.add_argument("--key")
        command.add_argument("--threads", type=_positive, default=int(os.environ.get("SLURM_CPUS_PER_TASK", "0")))
        command.set_defaults(run=run)
    status = commands.add_parser("status", help="what is done")
    status.add_argument("--out", required=True)
    status.add_argument("--missing", action="store_true", help="only the indices of tasks that are left, as 1,4-6")
    status.set_defaults(run=_run_status)
    return parser


def _positive(text):
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return number
