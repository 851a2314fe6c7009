# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes animated handles on many machines, by a Blender with the add-on installed; docs/guide/baking.md, "On a farm".

    blender -b SCENE.blend --python-exit-code 1 --python meanvalue_farm.py -- plan --out DIR --chunk 200
    blender -b --python-exit-code 1 --python meanvalue_farm.py -- bake --plan DIR/plan --index 0

    OUT/plan/plan.json            what there is to do, with versions; tasks.tsv and clips.tsv, a line for each index
    OUT/plan/CLIP.npz             all that the frames of a clip depend on
    OUT/CLIP/chunks/              frames that are done
    OUT/CLIP/CLIP.pc2             the point cache, and its report

Exit codes: 0 done, or done before; 1 failed; 2 bad arguments; 3 frames are missing; 4 a chunk is damaged (and was taken
out, so that it is missing now).
"""

import argparse
import dataclasses
import hashlib
import importlib
import itertools
import json
import os
import pathlib
import re
import sys
import time
import types

import numpy as np

LEGACY, EXTENSION = "meanvalue_deform", "meanvalue"
SCHEMA = 3
DONE, FAILED, BAD_ARGUMENTS, INCOMPLETE, DAMAGED = range(5)

#: Of a HandleClip, what is kept beside its mesh.
OF_CLIP = ("targets", "weights", "portable", "kept", "counts", "beside")

#: More frames than this are a slip of the pen.
MOST_FRAMES = 1_000_000

#: How often a line of progress is printed.
PROGRESS_SECONDS = 0.5

#: Modules of the add-on, each under the last part of its name; and those that only plan needs.
PARTS = (
    "errors", "posing.core.bind_input", "scene.core.whole_files",
    "solver.job", "solver.native_loader", "solver.session", "baking.bridge.clips",
    "baking.core.bake_times", "baking.core.point_cache",
)  # fmt: skip
PLANNING = (
    "live.engine", "scene.mesh_arrays", "scene.subject", "scene.frames", "baking.bridge.handle_source",
)  # fmt: skip
addon = None


def installed():
    """Name of the add-on's package in this Blender, which is enabled then."""
    import addon_utils
    import bpy

    names = [each.module for each in bpy.context.preferences.addons if each.module.endswith((LEGACY, f".{EXTENSION}"))]
    extensions = getattr(bpy.context.preferences, "extensions", None)  # Blender 4.2 and later
    for repository in extensions.repos if extensions else ():
        if pathlib.Path(repository.directory, EXTENSION).is_dir():
            names.append(f"bl_ext.{repository.module}.{EXTENSION}")
    for name in (*names, LEGACY):
        if addon_utils.check(name)[1] or addon_utils.enable(name):
            return name
    sys.exit("meanvalue: error: Mean-Value Deform is not installed in this Blender")


def parts_of(package, names=(*PARTS, *PLANNING)):
    found = {name.rpartition(".")[2]: importlib.import_module(f"{package}.{name}") for name in names}
    return types.SimpleNamespace(**found)


def main(arguments):
    """Returns the exit code."""
    global addon
    options = parser().parse_args(arguments)
    addon = addon or parts_of(installed())
    say(f"Mean-Value Deform farm: {options.command}, solver {addon.native_loader.module().__version__}")
    try:
        options.run(options)
    except (addon.errors.MeanValueError, IncompleteError) as error:
        print(f"openjd_fail: {error}\nmeanvalue: error: {error}", file=sys.stderr, flush=True)
        codes = {"DamagedCacheError": DAMAGED, "IncompleteError": INCOMPLETE}
        return codes.get(type(error).__name__, BAD_ARGUMENTS if isinstance(error, addon.errors.SceneError) else FAILED)
    return DONE


# -- plan ------------------------------------------------------------------------------------------------------------


def run_plan(options):
    clips = planned(options.clip, options.frames, options.portable)
    tasks, count = write_plan(options.out, clips, options.chunk)
    say(f"planned {tasks} tasks (indices 0 to {tasks - 1}) of {count} clips (0 to {count - 1}) in {options.out}/plan")


def planned(wanted, frames, portable=False):
    """[(name, BakePlan, triangles)] of clips as --clip writes them; None: every object with handles. @throws
    SceneError."""
    import bpy

    scene = bpy.context.scene
    frames = frames or f"{scene.frame_start}..{scene.frame_end}"
    wanted = wanted or [obj.name for obj in scene.objects if obj.type == "MESH" and obj.meanvalue.handles]
    if not wanted:
        raise addon.errors.SceneError("No object of the scene has handles")
    clips = [clip_of(text, frames, bpy.data.objects) for text in wanted]
    names = [name for name, _, _ in clips]
    if len({name.lower() for name in names}) < len(names):  # Windows and macOS take "Walk" and "walk" for one file
        raise addon.errors.SceneError(
            f"Two clips have one name: {', '.join(names)}. Give them names: --clip NAME=OBJECT:FRAMES"
        )
    return [(name, *plan_of(scene, obj, numbers, portable)) for name, obj, numbers in clips]


def clip_of(text, frames, objects):
    """(name, object, first and last frame) of NAME, NAME=OBJECT or NAME=OBJECT:FRAMES."""
    name, _, rest = text.partition("=")
    object_name, own_frames = rest or name, frames
    if rest and rest not in objects and ":" in rest:
        object_name, _, own_frames = rest.rpartition(":")
    obj = objects.get(object_name)
    if obj is None:
        raise addon.errors.SceneError(f"There is no object '{object_name}'")
    problem = addon.subject.object_problem(obj) or addon.subject.mode_problem(obj)
    if problem:
        raise addon.errors.SceneError(problem)
    runs = runs_of(parse(own_frames))
    if len(runs) != 1:
        raise addon.errors.SceneError(f"A clip has no gaps, but {own_frames} has. Give each part a name of its own")
    return addon.whole_files.file_name(re.sub(r"[^\w.-]", "_", name).lstrip(".-") or "clip"), obj, runs[0]


def plan_of(scene, obj, numbers, portable):
    source = addon.handle_source
    bind_input = source.bind(obj).bind_input
    triangles = addon.mesh_arrays.triangles(obj.data, bind_input.rest)
    times = addon.bake_times.sample_times(*numbers)
    with addon.engine.held():
        rows = addon.job.result_of(addon.frames.visit(scene, times, lambda: source.row(obj, bind_input)))
    return addon.clips.BakePlan(source.clip(obj, bind_input, np.array(rows), times, portable), times, 1.0), triangles


def write_plan(out, clips, chunk):
    """Freezes what there is to do. Returns how many tasks and clips. @throws CacheError.

    clips: as of planned(); chunk: frames of a task.
    """
    folder = pathlib.Path(out, "plan")
    listed, tasks = [], []
    for name, plan, triangles in clips:
        sha256 = save_clip(folder / f"{name}.npz", plan, triangles)
        frames = list(frames_of(plan))
        parts = [spelled(frames[begin : begin + chunk]) for begin in range(0, len(frames), chunk)]
        listed.append({"name": name, "key": plan.key, "sha256": sha256, "frames": spelled(frames), "chunks": parts})
        tasks += [f"{name}\t{part}\n" for part in parts]
    write_lines(folder / "tasks.tsv", tasks)
    write_lines(folder / "clips.tsv", [f"{clip['name']}\t{clip['frames']}\n" for clip in listed])
    content = {"schema": SCHEMA, "clips": listed, "versions": dict(addon.native_loader.environment())}
    write_lines(folder / "plan.json", [json.dumps({**content, "checksum": checksum(content)})])
    return len(tasks), len(listed)


def write_lines(path, lines):
    with addon.whole_files.replacing(path) as file:
        file.write("".join(lines).encode())


def save_clip(path, plan, triangles):
    """triangles m x 3 int32. Returns the file's SHA-256. @throws CacheError."""
    mesh = plan.clip.bind_input
    values = {f"mesh_{field.name}": getattr(mesh, field.name) for field in dataclasses.fields(mesh)}
    del values["mesh_kept_poses"]  # their stiffness is there
    values.update(times=plan.times, spacing=plan.spacing, triangles=triangles)
    if mesh.examples is not None:  # what they do, and not how
        values["mesh_examples"] = np.array(list(mesh.examples.shapes()))
        values.update(names=np.array(mesh.examples.names), revision=mesh.examples.revision)
    values.update({name: getattr(plan.clip, name) for name in OF_CLIP})
    with addon.whole_files.replacing(path) as file:
        np.savez(file, **{name: value for name, value in values.items() if value is not None})
        file.seek(0)
        return sha256_of(file)


def load_clip(path, sha256):
    """(BakePlan, triangles). Nothing is made of a file that is not what was written. @throws CacheError."""
    with addon.whole_files.telling(path), pathlib.Path(path).open("rb") as file:
        if sha256_of(file) != sha256:
            raise addon.errors.CacheError(f"'{path}' is damaged, or of another plan. Plan again")
        file.seek(0)
        with np.load(file, allow_pickle=False) as values:

            def value(name):
                """An array, or what was one number or text, or None where there was nothing."""
                found = values.get(name)
                return found.item() if found is not None and found.ndim == 0 else found

            kind = addon.bind_input.BindInput
            of_mesh = {field.name: value(f"mesh_{field.name}") for field in dataclasses.fields(kind)}
            if (shapes := of_mesh["examples"]) is not None:
                of_mesh["examples"] = types.SimpleNamespace(
                    names=value("names").tolist(), revision=value("revision"), shapes=lambda: shapes
                )
            mesh = kind(**of_mesh)
            clip = addon.clips.HandleClip(mesh, *map(value, OF_CLIP))
            return addon.clips.BakePlan(clip, value("times"), value("spacing")), value("triangles")


def sha256_of(file):
    state = hashlib.sha256()
    while piece := file.read(1 << 20):
        state.update(piece)
    return state.hexdigest()


# -- bake, merge, status ---------------------------------------------------------------------------------------------


def run_bake(options):
    out, clip, frames = task_of(options, "tasks.tsv")
    plan, triangles = load_and_check(out, clip)
    store = store_of(out, clip, frames_of(plan))
    missing = set(store.missing())
    if missing.isdisjoint(frames):
        say(f"{clip['name']} {spelled(frames)}: done before")
        return
    begun = time.monotonic()
    for first, last in runs_of(frames):
        if not missing.isdisjoint(range(first, last + 1)):
            begin = frames_of(plan).index(first)
            store.write(first, *solve(plan, triangles, begin, begin + last + 1 - first, options.threads))
    say(f"{clip['name']} {spelled(frames)}: {len(frames)} frames in {time.monotonic() - begun:.1f} s")


def run_merge(options):
    out, clip, frames = task_of(options, "clips.tsv")
    if len(runs_of(frames)) != 1:
        raise addon.errors.SceneError(f"A point cache has no gaps, but {spelled(frames)} has. Merge one range")
    plan, _triangles = load_and_check(out, clip)
    path = out / clip["name"] / f"{clip['name']}.pc2"
    store = store_of(out, clip, range(frames[0], frames[-1] + 1))
    header = dataclasses.replace(plan.header, start=float(frames[0]), samples=len(frames))
    key = f"{plan.key} {spelled(frames)}"
    if addon.point_cache.is_current(path, key, header):
        say(f"{path}: done before")
        return
    for chunk in store.folder.glob("*.npz"):
        addon.whole_files.remove_abandoned(chunk)
    problems = store.merge(path, header)
    addon.point_cache.write_marker(path, {"key": key, "clip": clip["name"]})
    say(f"{path}: {len(frames)} frames")
    for note in addon.bake_times.notes(frames, problems):
        say(f"warning: {note}")


def run_status(options):
    out = pathlib.Path(options.out)
    missing, index = [], 0
    for clip in read_plan(out / "plan")["clips"]:
        plan, _triangles = load_clip(out / "plan" / f"{clip['name']}.npz", clip["sha256"])
        store = store_of(out, clip, frames_of(plan))
        there = set(store.frames) - set(store.missing())
        for part in clip["chunks"]:
            if not there.issuperset(parse(part)):
                missing.append(index)
            index += 1
        if not options.missing:
            merged = "merged" if (out / clip["name"] / f"{clip['name']}.pc2").exists() else "not merged"
            print(f"{clip['name']}: {len(there)} of {len(store.frames)} frames, {merged}", flush=True)
    print(spelled(missing) if options.missing else f"{index - len(missing)} of {index} tasks are done", flush=True)


def solve(plan, triangles, begin, end, threads):
    """(rows, report), with lines of progress."""
    session, clip = addon.session, plan.clip

    def work(execution):
        binding = yield from session.bind_steps(clip.bind_input, triangles, execution, clip.portable)
        return (yield from clip.solve_rows(binding, begin, end, execution, threads))

    job, begun, told, count = addon.job.Job(work), time.monotonic(), 0, end - begin
    while True:
        is_over = job.wait(PROGRESS_SECONDS)
        stage, share = job.progress
        done = count if is_over else int(share * count) if stage == "solve" else 0
        minutes, seconds = divmod(time.monotonic() - begun, 60.0)
        for _ in range(told, done):  # a line for each frame, as Flamenco counts them
            print(f"Time: {minutes:02.0f}:{seconds:05.2f}")
        if done > told:
            print(f"openjd_progress: {100.0 * done / count:.1f}", flush=True)
        told = max(told, done)
        if is_over:
            return job.result()


def load_and_check(out, clip):
    """(BakePlan, triangles). The solver is part of the key. @throws MeanValueError."""
    plan, triangles = load_clip(out / "plan" / f"{clip['name']}.npz", clip["sha256"])
    if plan.key != clip["key"]:
        version = addon.native_loader.module().__version__
        raise addon.errors.MeanValueError(
            f"The plan was made for other inputs or another solver (here {version}). Install the same add-on on all "
            "machines, or plan again"
        )
    return plan, triangles


def task_of(options, table):
    """(OUT, clip of plan.json, frames): by --plan and --index, or by --out, --clip, --frames and --key."""
    error = addon.errors.SceneError
    if options.index is not None and options.plan is not None:
        folder = pathlib.Path(options.plan)
        plan = read_plan(folder)
        with addon.whole_files.telling(folder / table):
            lines = (folder / table).read_text(encoding="utf-8", errors="replace").splitlines()
        if not 0 <= options.index < len(lines):
            raise error(f"There is no line {options.index} in {folder / table}: it has 0 to {len(lines) - 1}")
        name, _, text = lines[options.index].partition("\t")
    elif None not in (options.out, options.clip, options.frames):
        folder, name, text = pathlib.Path(options.out, "plan"), options.clip, options.frames
        plan = read_plan(folder)
    else:
        raise error("Give --plan and --index, or --out, --clip, --frames and --key")
    clip = next((clip for clip in plan["clips"] if clip["name"] == name), None)
    if clip is None:
        raise error(f"There is no clip '{name}' in {folder / 'plan.json'}")
    if options.key is not None and options.key != clip["key"]:
        raise error(f"The key of '{name}' is {clip['key']} in {folder / 'plan.json'}, not {options.key}")
    frames = parse(text)
    outside = sorted(set(frames) - set(parse(clip["frames"])))
    if outside:
        raise error(f"Frames {spelled(outside)} are not in '{name}', {clip['frames']}")
    return folder.parent, clip, frames


def read_plan(folder):
    """@throws SceneError."""
    try:
        plan = json.loads((pathlib.Path(folder) / "plan.json").read_bytes())
        is_whole = plan.pop("checksum") == checksum(plan) and plan["schema"] == SCHEMA
    except (OSError, ValueError, TypeError, AttributeError, KeyError, RecursionError):
        is_whole = False
    if not is_whole:
        raise addon.errors.SceneError(f"There is no plan in {folder}, or it is damaged. Run plan, with the same --out")
    return plan


def checksum(plan):
    return hashlib.sha256(json.dumps(plan, sort_keys=True).encode()).hexdigest()


def store_of(out, clip, frames):
    return ChunkStore(out / clip["name"] / "chunks", clip["key"], frames)


def frames_of(plan):
    first = int(plan.times[0])
    return range(first, first + len(plan.times))


# -- frames that are done --------------------------------------------------------------------------------------------


class IncompleteError(Exception):
    """Frames of a bake are still missing."""


class ChunkStore:
    """The chunks of one clip in a folder, each a file that is there only when it is whole.

    Its name has the key of what is baked and the frames. So what was killed goes on where it was, changed settings
    never mix with old chunks, and several machines may work on one folder without knowing of each other.

    key       digest of everything that the frames depend on
    frames    range of all frames of the clip
    """

    def __init__(self, folder, key, frames):
        self.folder = pathlib.Path(folder)
        self.key = key[:16]  # paths of Windows are short
        self.frames = frames

    def write(self, first, rows, problems):
        """Keeps the rows (f, n, 3) from frame `first` on, with f texts on what went wrong. @throws CacheError."""
        name = f"{self.key}_{first:+07d}_{first + len(rows) - 1:+07d}.npz"
        with addon.whole_files.replacing(self.folder / name) as file:
            np.savez(file, rows=np.asarray(rows, "<f4"), problems=np.array(problems, str))

    def missing(self):
        """The frames that are in no chunk, ascending. Reads names alone."""
        where = self._where()
        return [frame for frame in self.frames if frame not in where]

    def merge(self, path, header):
        """Puts the chunks together into the cache `path`. Returns [text] of all frames, as write() was given them.

        @throws IncompleteError, DamagedCacheError, after which the chunk is gone, CacheError.
        """
        where, missing = self._where(), self.missing()
        if missing:
            raise IncompleteError(
                f"{len(missing)} of {len(self.frames)} frames are not baked yet, the first is {missing[0]}. Bake them "
                "first"
            )
        problems = []
        with addon.whole_files.replacing(path) as file:
            file.write(header.packed())
            for (chunk, first), frames in itertools.groupby(self.frames, where.get):
                frames = [frame - first for frame in frames]
                rows, texts = _read(chunk, header.vertices)
                file.write(rows[frames[0] : frames[-1] + 1])
                problems += texts[frames[0] : frames[-1] + 1]
        return problems

    def _where(self):
        """{frame: (path of the chunk that has it, its first frame)}."""
        where = {}
        for path in sorted(self.folder.glob(f"{self.key}_*.npz")):
            if match := re.fullmatch(r".*_([+-]\d+)_([+-]\d+)", path.stem):
                first, last = map(int, match.groups())
                for frame in range(max(first, self.frames[0]), min(last, self.frames[-1]) + 1):
                    where.setdefault(frame, (path, first))
        return where


def _read(path, vertices):
    """(rows, list of texts) of a chunk; the format has checksums. @throws DamagedCacheError."""
    with addon.whole_files.telling(path), path.open("rb") as file:
        try:
            with np.load(file) as content:
                rows, texts = np.ascontiguousarray(content["rows"]), content["problems"].tolist()
            if rows.dtype == np.dtype("<f4") and rows.shape == (len(texts), vertices, 3):
                return rows, texts
        except Exception:  # damage shows in any of a dozen errors of NumPy's
            pass
    path.unlink(missing_ok=True)
    raise addon.errors.DamagedCacheError(
        f"{path} is not what was written (a damaged disk, or another program). It was taken out: bake again, which "
        "solves only its frames"
    )


# -- frames, as people and render farms write them: 7, 1-200, 41,42, 1-3,10,11, 1..10, -5-10 --------------------------


def parse(text):
    """Frames, ascending, each once. @throws SceneError, also for more than MOST_FRAMES."""
    frames = set()
    for part in text.split(","):
        match = re.fullmatch(r"\s*(-?\d{1,12})\s*(?:(?:-|\.\.)\s*(-?\d{1,12})\s*)?", part)
        if match is None:
            raise addon.errors.SceneError(f"'{part.strip()[:60]}' is no frame and no range. Write 1-200, or 1-3,10,11")
        first, last = int(match[1]), int(match[2] or match[1])
        if not first <= last < first + MOST_FRAMES - len(frames):
            raise addon.errors.SceneError(
                f"The range '{part.strip()}' ends before it begins, or has more than {MOST_FRAMES:,} frames. Write "
                "another one"
            )
        frames.update(range(first, last + 1))
    return sorted(frames)


def runs_of(frames):
    """[(first, last)] of ascending frames."""
    found = []
    for frame in frames:
        if found and frame == found[-1][1] + 1:
            found[-1] = (found[-1][0], frame)
        else:
            found.append((frame, frame))
    return found


def spelled(frames):
    """The shortest way to write ascending frames: 1-3,10-11; parse() reads it."""
    return ",".join(str(first) if first == last else f"{first}-{last}" for first, last in runs_of(frames))


def say(text):
    print(f"meanvalue: {text}", flush=True)


def parser():
    made = argparse.ArgumentParser(prog="meanvalue_farm.py", description="Bakes animated handles on many machines.")
    commands = made.add_subparsers(dest="command", required=True)
    plan = commands.add_parser("plan", help="freeze the inputs (in Blender, with the scene)")
    plan.add_argument("--out", required=True)
    plan.add_argument("--chunk", type=positive, default=200, help="frames of a task")
    plan.add_argument("--clip", action="append", help="NAME, NAME=OBJECT or NAME=OBJECT:FRAMES; default: all")
    plan.add_argument("--frames", help="of clips that say nothing else; the scene's range if left out")
    plan.add_argument("--portable", action="store_true", help="the same bits on processors of different kinds; slower")
    plan.set_defaults(run=run_plan)
    for name, run in (("bake", run_bake), ("merge", run_merge)):
        command = commands.add_parser(name)
        command.add_argument("--plan", help="OUT/plan")
        command.add_argument("--index", type=int, help="line of tasks.tsv (bake) or clips.tsv (merge), from 0")
        for option in ("--out", "--clip", "--frames", "--key"):
            command.add_argument(option)
        command.add_argument("--threads", type=positive, default=int(os.environ.get("SLURM_CPUS_PER_TASK", "0")))
        command.set_defaults(run=run)
    status = commands.add_parser("status", help="what is done")
    status.add_argument("--out", required=True)
    status.add_argument("--missing", action="store_true", help="only the indices of tasks that are left, as 1,4-6")
    status.set_defaults(run=run_status)
    return made


def positive(text):
    number = int(text)
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text} is not 1 or more")
    return number


if __name__ == "__main__":
    sys.stdout.reconfigure(errors="backslashreplace")  # a console of Windows lacks most letters
    sys.exit(main(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else sys.argv[1:]))
