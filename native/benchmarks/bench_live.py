# SPDX-License-Identifier: MPL-2.0
"""Live posing in Blender, end to end: from a control that was moved to a mesh that Blender has evaluated again.

Runs itself in Blender without a window. The add-on's Follower is driven as its handlers drive it in the interface;
drawing, which depends on the graphics card, is left out. The picture is the first that shows the move: a draft
where the solve takes longer, else as solved. A frame ends with the solved mesh, and is split:

    native    the solver, as it tells itself
    transfer  writing the shape key
    add-on    reading controls, handing over to the thread and back, composing the result, telling an edit of the
              artist's from its own writing
    Blender   evaluating the moved control and, after the writing, the mesh

The same with an armature that deforms the mesh; and steps of a bone of it while the handles stay, where "ours" is all
that the add-on does in the handler.
"""

import functools
import os
import pathlib
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))

from native.benchmarks import generated_meshes, reporting, rigid

COLUMNS = [
    "mesh", "vertices", "bind ms", "picture ms", "frame ms", "worst ms", "native ms", "transfer ms",
    "add-on ms", "Blender ms", "without native ms",
]  # fmt: skip
BONE_COLUMNS = ["mesh", "vertices", "ours ms", "worst ms", "Blender ms"]
SHAPES = ("body", "bar")
SIZES = (10_000, 50_000, 200_000)
FRAMES = 30
PACKAGE = "meanvalue_deform"
GOAL_SIZE, GOAL_MS = 50_000, 18.0
RIGGED_GOAL = 1.5  # times the share without the solver of a mesh without a rig
BONE_GOAL_MS = 2.0
RIGGED = ("body", GOAL_SIZE)


def run_in_blender(arguments, script=__file__):
    """Outside of Blender: this script again, in it."""
    command = ["blender", "-b", "--factory-startup", "-noaudio", "--python-exit-code", "1", "--python", script, "--"]
    return subprocess.run([*command, *arguments], check=False).returncode


class Scene:
    """One object with a pin and a handle, as bench_speed moves it, and the stopwatches."""

    def __init__(self, shape, size, is_rigged=False):
        import bpy

        self.bpy = bpy
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.preferences.addon_enable(module=PACKAGE)
        names = [
            "live.engine",
            "live.following",
            "posing.live.follower",
            "scene.object_model",
            "scene.shape_keys",
            "solver.session",
        ]
        self.parts = {name: sys.modules[f"{PACKAGE}.{name}"] for name in names}
        job = generated_meshes.speed_job(shape, size)
        self.vertices = job.vertices
        self.obj = self._object(job)
        self.rest = job.vertices[job.anchors[job.pieces >= 0]]
        self.targets = job.targets[:, job.pieces >= 0]
        for name, members, operator in (
            ("Pin", job.anchors[job.pieces < 0], functools.partial(bpy.ops.meanvalue.add_handle, pin=True)),
            ("Handle", job.anchors[job.pieces >= 0], functools.partial(bpy.ops.meanvalue.add_handle, live=False)),
        ):
            self.obj.vertex_groups.new(name=name).add(members.tolist(), 1.0, 'REPLACE')
            bpy.context.view_layer.objects.active = self.obj
            operator(group=name)
        self.rig = self._armature() if is_rigged else None
        bpy.context.view_layer.update()
        self.control = self.obj.meanvalue.handles["Handle"].control
        self.start = np.array(self.control.matrix_world)
        self.follower = self.parts["posing.live.follower"].Follower(self.obj)
        self.transfer = self.native = 0.0
        self._watch()
        # In the interface our handlers are told of what a timer wrote alone; follow() tells them as that does.
        listeners = bpy.app.handlers.depsgraph_update_post
        listeners[:] = [each for each in listeners if not each.__name__.startswith("meanvalue")]

    def _object(self, job):
        mesh = self.bpy.data.meshes.new("Mesh")
        mesh.from_pydata(job.vertices.tolist(), [], job.faces.tolist())
        obj = self.bpy.data.objects.new("Object", mesh)
        self.bpy.context.collection.objects.link(obj)
        return obj

    def _armature(self):
        """Two bones, one above the other along the longest axis, that have all vertices."""
        bpy = self.bpy
        data = bpy.data.armatures.new("Rig")
        rig = bpy.data.objects.new("Rig", data)
        bpy.context.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        positions = np.array([vertex.co for vertex in self.obj.data.vertices])
        axis = int(np.ptp(positions, axis=0).argmax())
        low, high = positions[:, axis].min(), positions[:, axis].max()
        along = np.eye(3)[axis]
        bpy.ops.object.mode_set(mode='EDIT')
        for name, ends in (("Lower", (low, 0.5 * (low + high))), ("Upper", (0.5 * (low + high), high))):
            bone = data.edit_bones.new(name)
            bone.head, bone.tail = along * ends[0], along * ends[1]
        bpy.ops.object.mode_set(mode='OBJECT')
        share = np.clip((positions[:, axis] - low) / (high - low), 0.0, 1.0)
        groups = [self.obj.vertex_groups.new(name=name) for name in ("Lower", "Upper")]
        for index, weight in enumerate(share.tolist()):
            groups[0].add([index], 1.0 - weight, 'REPLACE')
            groups[1].add([index], weight, 'REPLACE')
        self.obj.modifiers.new("Armature", 'ARMATURE').object = rig
        return rig

    def bone_step(self, step):
        """Turns a bone. Returns milliseconds of ours, and of Blender."""
        from mathutils import Quaternion

        spent = []

        def listen(_scene, depsgraph):
            began = time.perf_counter()
            self.parts["live.engine"]._take_note(depsgraph)
            self.follow()
            spent.append(time.perf_counter() - began)

        listeners = self.bpy.app.handlers.depsgraph_update_post
        self.rig.pose.bones["Upper"].rotation_quaternion = Quaternion((1.0, 0.0, 0.0), 0.02 * step)
        listeners.append(listen)
        began = time.perf_counter()
        self.bpy.context.view_layer.update()
        whole = time.perf_counter() - began
        listeners.remove(listen)
        return 1e3 * np.array([sum(spent), whole - sum(spent)])

    def settle(self):
        """Goes on as Blender's timer does until there is nothing left to do."""
        while self.follower.wait(self.obj) is not None:
            time.sleep(self.parts["live.following"].TICK_SECONDS)
            self.follower.tick(self.obj)

    def _watch(self):
        """Stopwatches around the calls that write and solve."""
        keys, session = self.parts["scene.shape_keys"], self.parts["solver.session"]
        write, solve_steps = keys.write_positions, session.solve_steps

        def watched_write(*arguments):
            started = time.perf_counter()
            write(*arguments)
            self.transfer += time.perf_counter() - started

        def watched_solve_steps(*arguments, **options):
            solved, summary = yield from solve_steps(*arguments, **options)
            self.native += summary.timings["total"]
            return solved, summary

        keys.write_positions, session.solve_steps = watched_write, watched_solve_steps

    def bind(self):
        started = time.perf_counter()
        self.follow()
        return time.perf_counter() - started

    def is_caught_up(self):
        """Whether the mesh shows where the control is, or something is in the way."""
        return self.follower.problem is not None or self.follower._is_shown(self.obj)

    def follow(self):
        """As the interface does: the handler, then the timer, until the mesh shows where the control is.

        Returns whether the timer wrote it: only of that Blender tells the follower.
        """
        began = time.perf_counter()
        self.follower.follow(self.obj)
        self.drafted = None
        if self.is_caught_up():
            return False
        if self.follower._drag.drafted is not None:
            self.drafted = time.perf_counter() - began
        while not self.is_caught_up():
            time.sleep(self.parts["live.following"].TICK_SECONDS)
            self.follower.tick(self.obj)
        return True

    def place(self, step):
        """Moves the control as the handle of the job's `step`, and has Blender evaluate it."""
        from mathutils import Matrix

        rotation, shift = rigid.rigid_fit(self.rest, self.targets[step])
        move = np.eye(4)
        move[:3, :3], move[:3, 3] = rotation, shift
        self.control.matrix_world = Matrix((move @ self.start).tolist())
        self.bpy.context.view_layer.update()

    def evaluate(self):
        self.bpy.context.view_layer.update()
        self.obj.evaluated_get(self.bpy.context.evaluated_depsgraph_get())

    def tell(self):
        """As Blender does of what was written."""
        models = self.parts["scene.object_model"]
        for model in models.known_models(self.obj):
            model.told(self.obj, models.Change.KEYS)

    def frame(self, step):
        """Moves the control as the handle of the job's `step`.

        Returns milliseconds: whole, native, transfer, add-on, Blender, and until the first picture.
        """
        self.native = self.transfer = 0.0
        began = time.perf_counter()
        self.place(step)
        moved = time.perf_counter()
        is_told = self.follow()
        followed = time.perf_counter()
        self.evaluate()
        evaluated = time.perf_counter()
        if is_told:
            self.tell()
        ended = time.perf_counter()
        blender = (moved - began) + (evaluated - followed)
        addon = (followed - moved) + (ended - evaluated) - self.native - self.transfer
        picture = ended - began if self.drafted is None else blender + self.drafted
        return 1e3 * np.array([ended - began, self.native, self.transfer, addon, blender, picture])


def measure(shape, size, is_rigged=False):
    """Rows of both tables; the second is None without a rig."""
    scene = Scene(shape, size, is_rigged)
    bind = scene.bind()
    scene.frame(1)
    frames = np.array([scene.frame(step) for step in range(2, 2 + FRAMES)])
    whole, native, transfer, addon, blender, picture = np.median(frames, axis=0)
    name, count = f"{shape} on a rig" if is_rigged else shape, len(scene.obj.data.vertices)
    row = [name, count, 1e3 * bind, picture, whole, frames[:, 0].max(), native, transfer, addon, blender]
    row = [*map(_plain, row), _plain(np.median(frames[:, 0] - frames[:, 1]))]
    if not is_rigged:
        return row, None
    scene.settle()
    steps = np.array([scene.bone_step(step) for step in range(1, 1 + FRAMES)])
    return row, [name, count, *map(_plain, (np.median(steps[:, 0]), steps[:, 0].max(), np.median(steps[:, 1])))]


def _plain(value):
    return float(value) if isinstance(value, np.floating) else value


def main():
    import bpy

    arguments = sys.argv[sys.argv.index("--") + 1 :]
    sys.argv = [sys.argv[0], *arguments]
    json_path = reporting.json_argument(__doc__)
    bpy.ops.preferences.addon_install(filepath=os.environ["MEANVALUE_ADDON_ZIP"], overwrite=True)
    rows = [measure(shape, size)[0] for shape in SHAPES for size in SIZES]
    rigged, bones = measure(*RIGGED, is_rigged=True)
    rows.append(rigged)
    reporting.report(f"live posing, Blender {bpy.app.version_string}", COLUMNS, rows, json_path)
    reporting.report("steps of a bone with Live on", BONE_COLUMNS, [bones], json_path)
    for row in rows:
        if abs(row[1] - GOAL_SIZE) < 0.1 * GOAL_SIZE and row is not rigged:
            what = f"{row[0]}, {row[1]:,} vertices: without the solver {row[-1]:.1f} ms a frame"
            judge(what, row[-1], GOAL_MS, "ms")
    plain = next(row for row in rows if row[0] == RIGGED[0] and row[1] == rigged[1])
    share = rigged[-1] / plain[-1]
    judge(f"{rigged[0]}: without the solver {share:.2f} times that without a rig", share, RIGGED_GOAL, "times")
    judge(f"{bones[0]}: {bones[2]:.2f} ms of ours a step of a bone", bones[2], BONE_GOAL_MS, "ms")


def judge(what, value, goal, unit):
    print(f"{what}, at most {goal:g} {unit}: {'reached' if value <= goal else 'MISSED'}")


if __name__ == "__main__":
    if "bpy" in sys.modules:
        main()
    else:
        sys.exit(run_in_blender(sys.argv[1:]))
