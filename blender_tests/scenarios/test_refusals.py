# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that can go wrong: a message that says what to do, and the scene as it was."""

import contextlib

import bpy
import numpy as np
import pytest
from support import meshes, steps, tasks
from support.snapshot import assert_same, snapshot


@contextlib.contextmanager
def refused_unchanged(obj, *texts):
    before = snapshot(obj)
    with steps.refused(*texts):
        yield
    assert_same(before, snapshot(obj))


# -- the object ------------------------------------------------------------------------------------------------------


def operators():
    names = ("bind", "unbind", "solve", "solve_from_key", "remove_handle")
    return [getattr(bpy.ops.meanvalue, name) for name in names]


def test_no_active_object():
    for operator in operators():
        with steps.refused("There is no active object", "Click a mesh object"):
            operator()


def test_not_a_mesh():
    lamp = bpy.data.objects.new("Lamp", bpy.data.lights.new("Lamp", 'POINT'))
    bpy.context.collection.objects.link(lamp)
    meshes.activate(lamp)
    for operator in operators():
        with steps.refused("'Lamp' is not a mesh", "Click a mesh object"):
            operator()


@pytest.mark.parametrize(
    "mode, called", [('EDIT', "Edit Mode"), ('SCULPT', "Sculpt Mode"), ('WEIGHT_PAINT', "Weight Paint Mode")]
)
def test_wrong_mode(mode, called):
    obj = steps.posed_grid(meshes.grid())
    bpy.ops.object.mode_set(mode=mode)
    for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve, bpy.ops.meanvalue.solve_from_key):
        with refused_unchanged(obj, f"is in {called}", "Object Mode"):
            operator()


def test_linked_object(tmp_path):
    path = str(tmp_path / "library.blend")
    steps.posed_grid(meshes.grid())
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_source, wanted):
        wanted.objects = ["Grid"]
    linked = wanted.objects[0]
    bpy.context.collection.objects.link(linked)
    meshes.activate(linked)
    for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve, bpy.ops.meanvalue.solve_from_key):
        with refused_unchanged(linked, "linked from another file", "Make it local"):
            operator()


def test_linked_mesh(tmp_path):
    path = str(tmp_path / "library.blend")
    meshes.grid()
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(path, link=True) as (_source, wanted):
        wanted.meshes = ["Grid"]
    obj = bpy.data.objects.new("Local", wanted.meshes[0])
    bpy.context.collection.objects.link(obj)
    meshes.activate(obj)
    with refused_unchanged(obj, "The mesh of 'Local' is linked", "Make it local"):
        bpy.ops.meanvalue.bind()


# -- anchors and region ----------------------------------------------------------------------------------------------


def test_no_anchors_listed():
    obj = meshes.grid()
    with refused_unchanged(obj, "There are no handles yet", "press Add Handle"):
        bpy.ops.meanvalue.bind()


def test_anchor_group_deleted():
    obj = steps.posed_grid(meshes.grid())
    obj.vertex_groups.remove(obj.vertex_groups["Tip"])
    for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve_from_key):
        with refused_unchanged(obj, "no vertex group 'Tip'", "on the list of handles", "remove the handle"):
            operator()


def test_anchor_group_renamed():
    obj = steps.posed_grid(meshes.grid())
    obj.vertex_groups["Tip"].name = "Finger"
    with refused_unchanged(obj, "no vertex group 'Tip'", "Choose another group in Active Handle"):
        bpy.ops.meanvalue.solve_from_key()
    obj.meanvalue.handles[1].name = "Finger"
    steps.solve()


def test_anchor_group_empty():
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20], B=[])
    with refused_unchanged(obj, "Handle 'B' has no vertices", "Assign vertices"):
        bpy.ops.meanvalue.bind()


def test_no_faces():
    obj = meshes.make_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [])
    steps.list_anchors(obj, A=[0, 1, 2])
    with refused_unchanged(obj, "has no faces"):
        bpy.ops.meanvalue.bind()


def test_no_vertices():
    obj = meshes.make_object([], [])
    obj.vertex_groups.new(name="A")
    handle = obj.meanvalue.handles.add()
    handle.name, handle.follows = "A", 'REST'
    with refused_unchanged(obj, "no vertices"):
        bpy.ops.meanvalue.bind()


@pytest.mark.parametrize("anchors", [[0], [0, 4], [0, 1, 2, 3, 4]])
def test_too_few_fixed_points(anchors):
    obj = meshes.grid()
    for vertex in obj.data.vertices:
        vertex.co.z = 0.0  # so that a row is a line
    steps.list_anchors(obj, A=anchors)
    with refused_unchanged(obj, f"{len(anchors)} fixed point", "at least three", "not in one line", "Pin more"):
        bpy.ops.meanvalue.bind()


def test_region_group_deleted():
    obj = steps.bound_grid(meshes.grid())
    steps.add_group(obj, "Arm", range(25))
    obj.meanvalue.roi_group = "Arm"
    obj.vertex_groups.remove(obj.vertex_groups["Arm"])
    with refused_unchanged(obj, "no vertex group 'Arm'", "the region", "clear the field"):
        bpy.ops.meanvalue.bind()


def test_region_empty():
    obj = steps.bound_grid(meshes.grid())
    steps.add_group(obj, "Arm", [])
    obj.meanvalue.roi_group = "Arm"
    with refused_unchanged(obj, "region 'Arm' has no vertices", "Assign the vertices that may move"):
        bpy.ops.meanvalue.bind()


def test_region_inverted_to_nothing():
    obj = steps.bound_grid(meshes.grid())
    steps.add_group(obj, "Arm", range(25))
    obj.meanvalue.roi_group = "Arm"
    obj.meanvalue.roi_invert = True
    with refused_unchanged(obj, "The region is empty", "'Arm'", "Turn Invert off"):
        bpy.ops.meanvalue.bind()


def test_every_vertex_of_the_region_is_an_anchor():
    obj = steps.bound_grid(meshes.grid())
    steps.add_group(obj, "Arm", [0, 4, 20])
    obj.meanvalue.roi_group = "Arm"
    with refused_unchanged(obj, "Nothing is free to move", "enlarge the region"):
        bpy.ops.meanvalue.bind()


def test_no_part_is_held():
    """Two parts, and the three anchors are spread over them: neither can be posed."""
    obj = meshes.two_parts()
    steps.list_anchors(obj, A=[0, 3, 28])
    with refused_unchanged(obj, "nothing can be posed", "Pin three"):
        bpy.ops.meanvalue.bind()


# -- shape keys ------------------------------------------------------------------------------------------------------


def test_active_key_is_the_basis():
    obj = steps.posed_grid(meshes.grid())
    obj.active_shape_key_index = 0
    with refused_unchanged(obj, "active shape key is the rest shape", "Add a shape key"):
        bpy.ops.meanvalue.solve_from_key()


def test_absolute_shape_keys():
    obj = steps.posed_grid(meshes.grid())
    obj.data.shape_keys.use_relative = False
    with refused_unchanged(obj, "absolute", "Turn on Relative"):
        bpy.ops.meanvalue.solve_from_key()


def test_result_would_overwrite_the_basis():
    obj = steps.posed_grid(meshes.grid())
    obj.meanvalue.result_key = "Basis"
    with refused_unchanged(obj, "'Basis' is the rest shape", "another name"):
        bpy.ops.meanvalue.solve_from_key()


@pytest.mark.parametrize("name", ["", "  "])
def test_result_without_a_name(name):
    obj = steps.posed_grid(meshes.grid())
    obj.meanvalue.result_key = name
    with refused_unchanged(obj, "has no name", "Fill in Result"):
        bpy.ops.meanvalue.solve_from_key()


# -- numbers ---------------------------------------------------------------------------------------------------------


def test_nan_in_the_rest_shape():
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0, 4, 20])
    obj.data.vertices[7].co.x = float("nan")
    with refused_unchanged(obj, "rest shape", "the first is 7", "not numbers"):
        bpy.ops.meanvalue.bind()


def test_infinity_in_the_pose():
    obj = steps.posed_grid(meshes.grid())
    coordinates = steps.key_positions(obj, "Pose")
    coordinates[24, 1] = float("inf")
    obj.active_shape_key.data.foreach_set("co", coordinates.ravel())  # single values are clamped
    with refused_unchanged(obj, "shape key 'Pose'", "the first is 24", "not numbers"):
        bpy.ops.meanvalue.solve_from_key()


# -- the compiled module ---------------------------------------------------------------------------------------------


def test_native_module_missing(part, monkeypatch):
    obj = steps.posed_grid(meshes.grid())
    loader = part("solver.native_loader")
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    loader.forget()
    part("solver.session").clear()
    try:
        for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve_from_key):
            with refused_unchanged(obj, "solver", "Python 3.", "Install the add-on zip"):
                operator()
    finally:
        monkeypatch.undo()
        loader.forget()
    steps.solve()


def failing(error):
    def fail(*_arguments, **_options):
        raise error

    return fail


def failing_task(native, fail):
    """In place of native.start_bind: the error comes with the result, as it does from there."""
    start_bind = native.start_bind
    return lambda *arguments, **options: tasks.Changed(start_bind(*arguments, **options), fail)


@pytest.mark.parametrize(
    "kind, texts",
    [
        ("InvalidInput", ("cannot use this mesh", "edge 3 has 5 faces", "press Bind")),
        ("SolverFailure", ("The solver failed", "edge 3 has 5 faces", "closer to the rest shape")),
        ("MemoryError", ("not enough memory", "smaller region")),
    ],
)
def test_errors_of_the_native_module(native, part, monkeypatch, kind, texts):
    obj = steps.posed_grid(meshes.grid())
    part("solver.session").clear()
    error = MemoryError() if kind == "MemoryError" else getattr(native, kind)("edge 3 has 5 faces")
    monkeypatch.setattr(native, "start_bind", failing_task(native, failing(error)))
    for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve_from_key):
        with refused_unchanged(obj, *texts):
            operator()


def test_what_was_cancelled_changes_nothing(native, part, monkeypatch):
    obj = steps.posed_grid(meshes.grid())
    part("solver.session").clear()
    monkeypatch.setattr(native, "start_bind", failing_task(native, failing(native.Cancelled("stopped"))))
    before = snapshot(obj)
    for operator in (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve_from_key):
        assert operator() == {'CANCELLED'}
    assert_same(before, snapshot(obj))


class WrappedDeformer:
    """The real deformer with another answer to start_solve()."""

    def __init__(self, deformer, answer):
        self.report = deformer.report
        self._deformer = deformer
        self._answer = answer

    def start_solve(self, targets, **options):
        return tasks.Changed(self._deformer.start_solve(targets, **options), self._answer)


class Answer:
    """A solution with some of its values replaced."""

    def __init__(self, solution, **replaced):
        for name in ("vertices", "energy", "iterations", "converged", "stop_reason", "timings"):
            setattr(self, name, replaced.get(name, getattr(solution, name)))


@pytest.fixture
def answer_with(native, monkeypatch, part):
    """answer_with(f): the solver's answers go through f from now on."""

    def install(change):
        start_bind = native.start_bind
        part("solver.session").clear()

        def start(*arguments, **options):
            return tasks.Changed(start_bind(*arguments, **options), lambda made: WrappedDeformer(made, change))

        monkeypatch.setattr(native, "start_bind", start)

    return install


def test_answer_that_is_not_a_number(answer_with):
    obj = steps.posed_grid(meshes.grid())
    answer_with(lambda solution: Answer(solution, vertices=solution.vertices * float("nan")))
    with refused_unchanged(obj, "not numbers", "closer to the rest shape"):
        bpy.ops.meanvalue.solve_from_key()


def test_failure_in_solve_after_the_anchors_changed_keeps_the_old_binding(answer_with, native):
    obj = steps.posed_grid(meshes.grid())
    steps.add_group(obj, "More", [22])
    bpy.ops.meanvalue.add_handle(pin=True, group="More")
    answer_with(failing(native.SolverFailure("no descent")))
    with refused_unchanged(obj, "The solver failed", "no descent"):
        bpy.ops.meanvalue.solve_from_key()


def test_not_converged_is_a_warning_and_the_result_is_written(answer_with, capfd):
    obj = steps.posed_grid(meshes.grid())
    answer_with(lambda solution: Answer(solution, converged=False, stop_reason="iteration limit"))
    steps.solve()
    assert not obj.meanvalue.bound.solve_converged
    assert "Mean-Value" in obj.data.shape_keys.key_blocks
    told = capfd.readouterr().out
    assert "warning" in told.lower()
    assert "iteration limit" in told


def test_a_part_without_enough_fixed_points_is_a_warning(capfd):
    """The first part is posed, the second stays in place."""
    obj = meshes.two_parts()
    obj.meanvalue.loose_parts = 'stay'
    steps.list_anchors(obj, A=[0, 3, 12, 15])
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    told = capfd.readouterr().out
    assert "warning" in told.lower()
    assert "1 part of the mesh has fewer than three fixed points" in told
    steps.add_pose_key(obj)
    steps.move(obj, [15], (0.0, 0.0, 1.0))
    steps.solve()
    assert "1 part of the mesh has fewer" in capfd.readouterr().out
    rest, result = steps.key_positions(obj, "Basis"), steps.key_positions(obj, "Mean-Value")
    moved = np.abs(result - rest).max(axis=1)
    assert moved[16:].max() < 1e-6
    assert moved[:16].max() > 0.5


# -- the list of anchors ---------------------------------------------------------------------------------------------


def test_add_group_that_is_not_there():
    obj = meshes.grid()
    steps.add_group(obj, "A", [0])
    with refused_unchanged(obj, "no vertex group 'B'", "Choose one"):
        bpy.ops.meanvalue.add_handle(pin=True, group="B")


def test_add_group_twice():
    obj = meshes.grid()
    steps.list_anchors(obj, A=[0])
    with refused_unchanged(obj, "'A' is on the list already", "choose another"):
        bpy.ops.meanvalue.add_handle(pin=True, group="A")


def test_remove_from_an_empty_list():
    obj = meshes.grid()
    with refused_unchanged(obj, "No handle or pin is active"):
        bpy.ops.meanvalue.remove_handle()


def test_unbind_when_not_bound():
    obj = meshes.grid()
    with refused_unchanged(obj, "'Grid' is not bound"):
        bpy.ops.meanvalue.unbind()
