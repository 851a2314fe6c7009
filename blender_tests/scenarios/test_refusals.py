# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that can go wrong: a message that names it, and the scene as it was."""

import types

import bpy
import numpy as np
import pytest
from support import baking, handles, libraries, meshes, steps, tasks
from support.snapshot import assert_same, snapshot

BIND = (bpy.ops.meanvalue.bind,)
SOLVE = (bpy.ops.meanvalue.solve_from_key,)
ALL = (bpy.ops.meanvalue.bind, bpy.ops.meanvalue.solve, bpy.ops.meanvalue.solve_from_key)


def assert_refused_unchanged(obj, operators, *texts):
    for operator in operators:
        with steps.refused(*texts, unchanged=obj):
            operator()


# -- the object ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("active", ["no active object", "'Lamp' is not a mesh", "'Crowd' stands for a collection"])
def test_no_mesh_is_active(active):
    if "Lamp" in active:
        meshes.activate(meshes.new_object("Lamp", bpy.data.lights.new("Lamp", 'POINT')))
    if "Crowd" in active:
        meshes.activate(meshes.new_object("Crowd", None))
        bpy.context.object.instance_collection = bpy.data.collections.new("Crowd")
    for name in ("bind", "solve", "solve_from_key", "remove_handle"):
        with steps.refused(active):
            getattr(bpy.ops.meanvalue, name)()


@pytest.mark.parametrize("mode", ['EDIT', 'SCULPT', 'WEIGHT_PAINT'])
def test_wrong_mode(mode):
    obj = steps.posed_grid(meshes.grid())
    bpy.ops.object.mode_set(mode=mode)
    assert_refused_unchanged(obj, ALL, "'Grid'", "Object Mode")


# -- handles, region, keys and numbers -------------------------------------------------------------------------------


def posed(change):
    """A set-up: the posed grid, changed."""

    def make():
        obj = steps.posed_grid(meshes.grid())
        change(obj)
        return obj

    return make


def listed(change=None, **groups):
    """A set-up: a grid with these groups on the list."""

    def make():
        obj = meshes.grid()
        if change is not None:
            change(obj)
        steps.list_anchors(obj, **groups)
        return obj

    return make


def in_region(*members):
    """A set-up: the bound grid with a region."""

    def make():
        obj = steps.bound_grid(meshes.grid())
        steps.add_group(obj, "Arm", members)
        obj.meanvalue.roi_group = "Arm"
        return obj

    return make


def region_deleted():
    obj = in_region(0)()
    obj.vertex_groups.remove(obj.vertex_groups["Arm"])
    return obj


def without_faces():
    obj = meshes.make_object([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)], [])
    steps.list_anchors(obj, A=[0, 1, 2])
    return obj


def without_vertices():
    obj = meshes.make_object([], [])
    obj.vertex_groups.new(name="A")
    obj.meanvalue.handles.add().name = "A"
    obj.meanvalue.handles[0].follows = 'REST'
    return obj


def three_points_on_two_parts():
    """Neither can be posed."""
    obj = meshes.two_parts()
    steps.list_anchors(obj, A=[0, 3, 28])
    return obj


def flatten(obj):
    for vertex in obj.data.vertices:
        vertex.co.z = 0.0  # so that a row is a line


def put_nan(obj):
    obj.data.vertices[7].co.x = float("nan")


def put_infinity(obj):
    coordinates = steps.key_positions(obj, "Pose")
    coordinates[24, 1] = float("inf")
    obj.active_shape_key.data.foreach_set("co", coordinates.ravel())  # single values are clamped


CASES = {
    "no handles": (meshes.grid, BIND, ["Add Handle"]),
    "no handle to remove": (meshes.grid, (bpy.ops.meanvalue.remove_handle,), ["no active handle or pin"]),
    "group deleted": (posed(lambda obj: obj.vertex_groups.remove(obj.vertex_groups["Tip"])), BIND + SOLVE, ["'Tip'"]),
    "group renamed": (posed(lambda obj: setattr(obj.vertex_groups["Tip"], "name", "Finger")), SOLVE, ["'Tip'"]),
    "group empty": (listed(A=[0, 4, 20], B=[]), BIND, ["'B' has no vertices"]),
    "no faces": (without_faces, BIND, ["no faces"]),
    "no vertices": (without_vertices, BIND, ["no vertices"]),
    "two points": (listed(flatten, A=[0, 4]), BIND, ["at least three"]),
    "a line": (listed(flatten, A=[0, 1, 2, 3, 4]), BIND, ["not in one line"]),
    "two parts": (three_points_on_two_parts, BIND, ["Pin three"]),
    "region deleted": (region_deleted, BIND, ["'Arm'"]),
    "region empty": (in_region(), BIND, ["'Arm'"]),
    "active key is the basis": (posed(lambda obj: setattr(obj, "active_shape_key_index", 0)), SOLVE, ["rest shape"]),
    "absolute keys": (posed(lambda obj: setattr(obj.data.shape_keys, "use_relative", False)), SOLVE, ["Relative"]),
    "result is the basis": (posed(lambda obj: setattr(obj.meanvalue, "result_key", "Basis")), SOLVE, ["'Basis'"]),
    "result without a name": (posed(lambda obj: setattr(obj.meanvalue, "result_key", "  ")), SOLVE, ["no name"]),
    "NaN at rest": (listed(put_nan, A=[0, 4, 20]), BIND, ["not numbers", "7"]),
    "NaN where it is grabbed": (listed(put_nan), (lambda: bpy.ops.meanvalue.grab(vertex=20),), ["not numbers", "7"]),
    "infinity in the pose": (posed(put_infinity), SOLVE, ["'Pose'", "not numbers", "24"]),
}


@pytest.mark.parametrize("make, operators, texts", CASES.values(), ids=CASES.keys())
def test_refused(make, operators, texts):
    assert_refused_unchanged(make(), operators, *texts)


def test_a_group_that_was_renamed_is_chosen_again():
    obj = posed(lambda obj: setattr(obj.vertex_groups["Tip"], "name", "Finger"))()
    obj.meanvalue.handles[1].name = "Finger"
    steps.solve()


# -- the compiled module ---------------------------------------------------------------------------------------------


def test_native_module_missing(part, monkeypatch):
    obj = steps.posed_grid(meshes.grid())
    loader = part("solver.native_loader")
    monkeypatch.setattr(loader, "MODULE_NAMES", ("nowhere.meanvalue",))
    loader.forget()
    part("solver.session").cache.clear()
    try:
        assert_refused_unchanged(obj, BIND + SOLVE, "Install")
    finally:
        monkeypatch.undo()
        loader.forget()
    steps.solve()


@pytest.fixture
def gives(monkeypatch, part):
    """gives(name, f): what tasks of the solver that are begun by that name give goes through f from now on."""
    session = part("solver.session")
    steps = session.steps

    def install(name, change):
        def changed(function, *arguments, **options):
            begin = lambda *a, **k: tasks.Changed(function(*a, **k), change)  # noqa: E731
            return steps(begin if function.__name__ == name else function, *arguments, **options)

        session.cache.clear()
        monkeypatch.setattr(session, "steps", changed)

    return install


def failing(error):
    def fail(*_arguments, **_options):
        raise error

    return fail


@pytest.mark.parametrize("kind", ["InvalidInput", "SolverFailure", "TooLittleMemory", "MemoryError", "Cancelled"])
def test_errors_of_the_native_module(native, gives, kind):
    obj = steps.posed_grid(meshes.grid())
    error = MemoryError() if kind == "MemoryError" else getattr(native, kind)("edge 3 has 5 faces")
    gives("start_bind", failing(error))
    if kind != "Cancelled":
        assert_refused_unchanged(obj, BIND + SOLVE, "memory" if kind == "MemoryError" else "edge 3 has 5 faces")
        return
    before = snapshot(obj)
    assert [operator() for operator in BIND + SOLVE] == [{'CANCELLED'}] * 2
    assert_same(before, snapshot(obj))


def answer(solution, **replaced):
    """A solution with some of its values replaced."""
    names = ("vertices", "energy", "iterations", "converged", "stop_reason", "timings")
    return types.SimpleNamespace(**{name: getattr(solution, name) for name in names} | replaced)


def test_answer_that_is_not_a_number(gives):
    obj = steps.posed_grid(meshes.grid())
    gives("start_solve", lambda solution: answer(solution, vertices=solution.vertices * float("nan")))
    assert_refused_unchanged(obj, SOLVE, "not numbers")


def test_failure_in_solve_after_the_handles_changed_keeps_the_old_binding(gives, native):
    obj = steps.posed_grid(meshes.grid())
    steps.add_handle(obj, "More", [22], pin=True)
    gives("start_solve", failing(native.SolverFailure("no descent")))
    assert_refused_unchanged(obj, SOLVE, "no descent")


def test_not_converged_is_a_warning_and_the_result_is_written(gives, capfd):
    obj = steps.posed_grid(meshes.grid())
    gives("start_solve", lambda solution: answer(solution, converged=False, stop_reason="iteration limit"))
    steps.solve()
    assert "Mean-Value" in obj.data.shape_keys.key_blocks
    told = capfd.readouterr().out
    assert "warning" in told.lower() and "iteration limit" in told


def test_a_part_without_enough_fixed_points_stays_and_is_a_warning(capfd):
    obj = meshes.two_parts()
    obj.meanvalue.loose_parts = 'stay'
    steps.list_anchors(obj, A=[0, 3, 12, 15])
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    assert "warning" in capfd.readouterr().out.lower()
    steps.add_pose_key(obj)
    steps.move(obj, [15], (0.0, 0.0, 1.0))
    steps.solve()
    moved = np.abs(steps.key_positions(obj, "Mean-Value") - steps.key_positions(obj, "Basis")).max(axis=1)
    assert moved[16:].max() < 1e-6
    assert moved[:16].max() > 0.5


# -- what cannot work is greyed and says why ---------------------------------------------------------------------------


#: By the tool, after a file was chosen, or with another mesh that may be given: its buttons are greyed one by one.
ELSEWHERE = {"import_motion", "grab", "morph"}


def names():
    found = [name for name in dir(bpy.types) if name.startswith("MEANVALUE_OT_")]
    return sorted({name.removeprefix("MEANVALUE_OT_") for name in found} - ELSEWHERE)


def fresh():
    meshes.tube()


def in_edit_mode():
    meshes.tube()
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='DESELECT')


def linked(tmp_path):
    obj = meshes.tube()
    obj.data = libraries.linked(tmp_path, obj.data, "meshes")


@pytest.mark.parametrize("kind", ["fresh", "edit", "linked"])
def test_refused_with_a_reason_or_without_an_error(kind, tmp_path):
    wrong = []
    for name in names():
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=False)
        {"fresh": fresh, "edit": in_edit_mode, "linked": lambda: linked(tmp_path)}[kind]()
        operator = getattr(bpy.ops.meanvalue, name)
        try:
            operator()
        except RuntimeError as error:
            refusal = f"bpy.ops.meanvalue.{name}.poll() "
            if refusal not in str(error) or "context is incorrect" in str(error):
                wrong.append((name, str(error)))
    assert wrong == []


@pytest.mark.parametrize("way", ["handles", "bake"])
def test_keyframes_go_into_a_copy_of_a_linked_action(tmp_path, way):
    """Into the linked one they would be gone when the file is opened again."""
    obj, control = baking.animated_tube()
    animated = control if way == "handles" else obj.shape_key_add(name="Smile").id_data
    if way == "bake":
        animated.key_blocks["Smile"].keyframe_insert("value", frame=1)
    animation = animated.animation_data
    action = animation.action = libraries.linked(tmp_path, animation.action, "actions")
    before = [len(curve.keyframe_points) for curve in baking.curves(animated)]
    bpy.context.scene.frame_set(40)
    if way == "handles":
        assert bpy.ops.meanvalue.keyframe_handles() == {'FINISHED'}
    else:
        baking.bake(target='SHAPE_KEYS')
    assert animation.action.library is None
    assert [len(curve.keyframe_points) for curve in baking.curves(animated)] != before
    animation.action = action
    assert [len(curve.keyframe_points) for curve in baking.curves(animated)] == before


def test_a_linked_control_takes_no_keyframes(tmp_path, capfd):
    obj, _control = handles.tube()
    prop = libraries.linked(tmp_path, meshes.new_object("Prop"), "objects")
    obj.meanvalue.handles["Top"].control = prop
    meshes.activate(obj)
    bpy.ops.meanvalue.keyframe_handles()
    assert prop.animation_data is None and "would not be saved" in capfd.readouterr().out
