# SPDX-License-Identifier: GPL-3.0-or-later
"""Live by handlers and timers: what was written or edited, and by whom, is told by comparing."""

import functools

import bpy
import numpy as np
import pytest
from mathutils import Vector
from support import handles, meshes, rigs, sheets, steps
from support.handles import TOP, move, rest, shown, update
from support.interface import interface, is_settled


@pytest.fixture
def timers():
    with interface() as timers:
        yield timers


def posed(timers):
    obj, control = handles.tube()
    timers.run(0.1)
    move(control, (1.0, 0.0, 0.0))
    timers.run(0.1)
    update()
    timers.run(0.1)
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 1.0).max() < 1e-4
    return obj, control


def test_the_timer_ends_when_all_is_settled(timers):
    obj, _control = posed(timers)
    assert is_settled(obj)
    update()  # Blender tells of what was written
    assert timers.run(0.1) < 5 and is_settled(obj)


def test_from_a_press_to_the_pose_faces_are_read_once_and_no_weights(timers, part, monkeypatch):
    obj = meshes.tube(handles.RINGS, handles.SEGMENTS, "Tube")
    meshes.activate(obj)
    reads, arrays, groups = [], part("scene.mesh_arrays"), part("scene.vertex_groups")
    for name, module, function in (("faces", arrays, "faces"), ("weights", groups.array, "array")):
        read = getattr(module, function)
        told = functools.partial(lambda name, read, *given: (reads.append(name), read(*given))[1], name, read)
        monkeypatch.setattr(module, function, told)
    bpy.ops.meanvalue.grab(vertex=int(TOP[0]), size=0.3, offset=(0.5, 0.0, 0.0))
    for _update in range(3):
        timers.run(0.1)
        update()
    assert is_settled(obj) and abs(shown(obj)[TOP[0], 0] - rest(obj)[TOP[0], 0] - 0.5) < 1e-3
    assert reads == ["faces"]
    obj.vertex_groups[obj.meanvalue.roi_group].add([0], 1.0, 'REPLACE')
    assert part("posing.bridge.region").weights(obj)[0] == 1.0
    timers.run(0.1)
    assert set(reads[1:]) == {"faces", "weights"}


class Gate:
    """A step of a job that is over when it is opened."""

    def __init__(self):
        self.finished = True

    def wait(self, _seconds=None):
        return self.finished


@pytest.fixture
def dragged(timers, part, monkeypatch):
    """(object, control, Gate of its solves), dragged by three steps."""
    obj, control = handles.tube()
    session, gate = part("solver.session"), Gate()
    solve_steps = session.solve_steps

    def slow_steps(*arguments, **options):
        yield gate
        return (yield from solve_steps(*arguments, **options))

    monkeypatch.setattr(session, "solve_steps", slow_steps)
    monkeypatch.setattr(part("live.following"), "QUIET_SECONDS", 5.0)  # the drag goes on, however slow the machine
    three_answers(timers, part, obj, control, (0.2, 0.0, 0.0))
    return obj, control, gate


def three_answers(timers, part, obj, control, offset):
    for _answer in range(3):
        move(control, offset)
        while part("live.roll").follower_of(obj).wait(obj) < 0.1:
            timers.step()


def test_what_takes_long_is_shown_as_a_draft_meanwhile_of_each_mesh_by_its_own_answers(timers, part, dragged):
    obj, control, gate = dragged
    other, its_control = handles.tube("Other")
    three_answers(timers, part, other, its_control, (0.0, 0.1, 0.0))
    gate.finished = False
    move(control, (0.2, 0.0, 0.0))
    move(its_control, (0.0, 0.1, 0.0))
    drafts = [(each, shown(each)) for each in (obj, other)]
    for (each, shape), offset in zip(drafts, ((0.8, 0.0, 0.0), (0.0, 0.4, 0.0)), strict=True):
        assert not is_settled(each)
        assert np.abs(shape[TOP] - rest(each)[TOP] - offset).max() < 1e-6
    gate.finished = True
    timers.run(0.1)
    for each, shape in drafts:
        assert is_settled(each)
        assert 0.0 < np.linalg.norm(shown(each) - shape, axis=1).max() < 0.02


def test_a_draft_gives_way_to_the_last_answer_when_live_is_turned_off(dragged):
    obj, control, gate = dragged
    answer = shown(obj)
    gate.finished = False
    move(control, (0.2, 0.0, 0.0))
    assert np.abs(shown(obj) - answer).max() > 0.1
    obj.meanvalue.live = False
    update()
    assert np.array_equal(shown(obj), answer)


def test_a_draft_gives_way_to_the_last_answer_where_the_solve_fails(timers, part, dragged, monkeypatch):
    obj, control, gate = dragged
    answer = shown(obj)

    def failing_steps(*_arguments, **_options):
        yield gate
        raise part("errors").SolverError("There is no way there")

    monkeypatch.setattr(part("solver.session"), "solve_steps", failing_steps)
    gate.finished = False
    move(control, (0.2, 0.0, 0.0))
    assert np.abs(shown(obj) - answer).max() > 0.1
    gate.finished = True
    timers.run(0.1)
    assert part("live.engine").status(obj) == ("Waiting: There is no way there.", True)
    assert np.array_equal(shown(obj), answer)


def test_a_draft_is_symmetric_where_answers_are(timers, part, dragged):
    obj, control, gate = dragged
    obj.meanvalue.symmetric = 'Y'
    three_answers(timers, part, obj, control, (0.2, 0.0, 0.0))
    answer = shown(obj)
    gate.finished = False
    move(control, (0.2, 0.0, 0.0))
    draft = shown(obj)
    assert np.abs(draft - answer).max() > 0.1
    mirror = np.array([1.0, -1.0, 1.0])
    distances = np.linalg.norm(rest(obj)[:, None] - mirror * rest(obj)[None], axis=2)
    assert distances.min(axis=1).max() < 1e-5
    assert np.abs(draft - mirror * draft[distances.argmin(axis=1)]).max() < 1e-5


class EarlyGate(Gate):
    """A bind that is not over, and has something to show."""

    def __init__(self, early):
        self.finished, self.early = False, early


@pytest.fixture
def bound_slowly(timers, part, monkeypatch):
    """(object, control, EarlyGate of its binding): it is being bound, and can be posed meanwhile."""
    session, module = part("solver.session"), part("solver.native_loader").module()
    bind_steps, gates = session.bind_steps, []

    def slow_steps(bind_input, triangles, execution, **options):
        mesh = bind_input.solver_mesh
        gates.append(EarlyGate(module.Deformer(mesh.rest, mesh.triangles(triangles), mesh.anchors)))
        yield gates[-1]
        return (yield from bind_steps(bind_input, triangles, execution, **options))

    monkeypatch.setattr(session, "bind_steps", slow_steps)
    monkeypatch.setattr(session, "EARLY_VERTICES", 1)
    session.cache.clear()
    obj, control = handles.tube()
    step_on(timers)
    return obj, control, gates[-1]


def step_on(timers):
    for _step in range(100):
        timers.step(0.01)


def test_a_mesh_is_posed_while_it_is_bound(timers, bound_slowly):
    obj, control, gate = bound_slowly
    assert obj.data.shape_keys is None  # nothing has moved since
    for _step in range(3):
        move(control, (0.2, 0.0, 0.0))
        while obj.data.shape_keys is None:
            timers.step(0.01)
        step_on(timers)
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 0.6).max() < 1e-6
    assert not is_settled(obj)
    gate.finished = True
    timers.run(1.0)
    assert is_settled(obj)
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 0.6).max() < 1e-6


def test_what_was_shown_while_it_was_bound_gives_way(timers, part, bound_slowly, monkeypatch):
    obj, control, gate = bound_slowly
    move(control, (0.2, 0.0, 0.0))
    step_on(timers)
    assert np.abs(shown(obj) - rest(obj)).max() > 0.1

    def fails(*_arguments, **_options):
        raise part("errors").SolverError("This mesh cannot be bound")

    monkeypatch.setattr(part("solver.session"), "steps", fails)
    gate.finished = True
    timers.run(0.1)
    assert part("live.engine").status(obj) == ("Waiting: This mesh cannot be bound.", True)
    assert np.array_equal(shown(obj), rest(obj))


@pytest.mark.parametrize("change", ["none", "rigidity", "look again", "edit"])
def test_live_off_while_a_mesh_is_bound_leaves_it_at_rest_whatever_was_changed(timers, part, bound_slowly, change):
    obj, control, _gate = bound_slowly
    move(control, (0.2, 0.0, 0.0))
    step_on(timers)
    assert np.abs(shown(obj) - rest(obj)).max() > 0.1
    if change == "rigidity":
        obj.meanvalue.rigidity *= 2.0
        obj.update_tag()
    elif change == "look again":
        part("live.engine").look_again(obj)
    elif change == "edit":
        obj.data.update()  # as after one that moved nothing
    if change != "none":
        update()
        step_on(timers)
    obj.meanvalue.live = False
    update()
    assert np.array_equal(shown(obj), rest(obj))


def test_a_mesh_that_was_changed_while_it_is_bound_is_not_written_to(timers, part, bound_slowly):
    obj, control, _gate = bound_slowly
    move(control, (0.2, 0.0, 0.0))
    obj.data.vertices.add(1)
    update()
    step_on(timers)
    assert part("live.roll").follower_of(obj).problem is None


def test_a_bind_goes_on_anew_where_the_mesh_was_changed_in_a_render(timers, part, bound_slowly, monkeypatch):
    obj, _control, _gate = bound_slowly
    engine = part("live.engine")
    with monkeypatch.context() as rendering:
        rendering.setattr(engine, "_notice_end_of_rendering", lambda: None)
        engine.meanvalue_render_started()
        obj.data.vertices.add(1)
        update()
    engine.meanvalue_render_ended()
    part("live.engine").forget_renders()  # there is no window to tell in that the render shows less
    monkeypatch.undo()  # the next bind is quick
    timers.run(1.0)
    assert is_settled(obj)


def test_a_large_mesh_is_sketched_in_the_one_evaluation_of_a_press(timers, part, monkeypatch):
    monkeypatch.setattr(part("solver.session"), "EARLY_VERTICES", 1)
    obj, told = sheets.sheet(), []

    def listener(_scene, depsgraph):
        told.extend(each.is_updated_geometry for each in depsgraph.updates if each.id.original == obj)

    bpy.app.handlers.depsgraph_update_post.append(listener)
    with part("scene.kept").writing(obj):
        grip = part("posing.bridge.grip").Grip(obj, sheets.MIDDLE, 0.3)
        grip.move(obj, Vector((0.0, 0.0, 2.0)))
        part("live.engine").have_all("tick")
    bpy.app.handlers.depsgraph_update_post.remove(listener)
    assert sum(told) == 1
    assert np.abs(sheets.lift(obj) - 2.0 * sheets.region_weights(obj)).max() < 0.04
    assert abs(sheets.lift(obj)[sheets.MIDDLE] - 2.0) < 1e-5 and part("live.roll").follower_of(obj)._job is None
    timers.run(1.0)
    assert is_settled(obj)
    other = sheets.sheet()
    sheets.grab(size=0.3)
    timers.run(1.0)
    assert np.array_equal(shown(obj), shown(other))


def test_an_edit_of_the_pose_is_kept_where_the_mesh_is_posed_before_it_is_bound(timers, part, bound_slowly):
    obj, control, _gate = bound_slowly
    move(control, (0.2, 0.0, 0.0))
    step_on(timers)
    obj.active_shape_key_index, obj.data.shape_keys.key_blocks[1].data[40].co.y = 1, 0.5
    edited = shown(obj)
    part("registration").meanvalue_another_file()
    step_on(timers)
    move(control, (0.2, 0.0, 0.0))
    step_on(timers)
    assert np.abs(shown(obj) - edited).max() > 0.1
    assert np.array_equal(steps.key_positions(obj, "Mean-Value Edit"), edited)


def test_without_live_no_timer_runs(timers):
    _obj, control = handles.tube(live=False)
    move(control, (1.0, 0.0, 0.0))
    assert timers.run() == 0


def test_keys_are_made_by_timers_alone(timers):
    """What a handler makes is no part of any undo step."""
    obj, control = handles.tube()
    for _step in range(5):
        move(control, (0.2, 0.0, 0.0))
        assert obj.data.shape_keys is None
    timers.run(0.1)
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 1.0).max() < 1e-4


def edit_group(obj, _write):
    obj.vertex_groups["Top"].remove([TOP[0]])


def edit_points(obj, _write):
    for point in obj.data.shape_keys.key_blocks[handles.RESULT].data:
        point.co.z += 3.0


def write_result(obj, write):
    write(obj.data, obj.data.shape_keys.key_blocks[handles.RESULT], shown(obj) + np.float32(0.5))


@pytest.mark.parametrize("edit", [edit_group, edit_points, write_result])
@pytest.mark.parametrize("is_dragged", [False, True], ids=["at rest", "in a drag"])
def test_an_edit_is_noticed_beside_our_own_writing(timers, part, edit, is_dragged):
    obj, control = posed(timers)
    if is_dragged:
        move(control, (0.5, 0.0, 0.0))
        timers.step()
        control.location.x -= 0.5
    edit(obj, part("scene.shape_keys").write_positions)
    update()
    timers.run(0.1)
    update()
    timers.run(0.1)
    off = shown(obj) - rest(obj)
    if edit is edit_group:
        assert part("posing.bridge.scene_input").member_count(obj, 1) == 7
        assert abs(off[TOP[1], 0] - 1.0) < 1e-3 and abs(off[TOP[0], 0] - 1.0) > 1e-6
    else:
        assert np.abs(off[TOP] - (1.0, 0.0, 0.0)).max() < 1e-3


def test_another_rest_shape_of_a_script_is_told(timers, part):
    """Later Blenders tell of it as of a driven slider."""
    obj, _control = posed(timers)
    basis = obj.data.shape_keys.reference_key
    store, attribute = part("compat").key_store(basis)
    shape = np.empty(3 * len(store), np.float32)
    store.foreach_get(attribute, shape)
    store.foreach_set(attribute, 1.5 * shape)
    if not part("compat").points_tell_as_sliders(basis):
        obj.data.shape_keys.update_tag()
    update()
    timers.run(0.1)
    assert part("live.engine").status(obj)[1] and steps.is_stale(obj)


def test_what_is_edited_beside_a_bone_step_is_found(timers, part):
    obj, rig = rigs.posed_arm()
    timers.run(0.1)
    obj.vertex_groups["Top"].remove([TOP[0], TOP[1]])
    rigs.bend(rig, 20.0)
    timers.run(0.1)
    assert part("posing.bridge.scene_input").member_count(obj, 1) == 6
    obj.data.shape_keys.reference_key.data[TOP[2]].co.x += 0.25
    rigs.bend(rig, 40.0)
    timers.run(0.1)
    assert "rest shape" in part("live.engine").status(obj)[0]


def test_it_goes_on_when_edit_mode_is_left(timers, part):
    obj, control = posed(timers)
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    before = shown(obj)
    move(control, (1.0, 0.0, 0.0))
    assert timers.run(0.1) < 3 and "Edit Mode" in part("live.engine").status(obj)[0]
    assert np.array_equal(shown(obj), before)
    bpy.ops.object.mode_set(mode='OBJECT')
    update()
    timers.run(0.1)
    assert part("live.engine").status(obj) is None
    assert np.abs(shown(obj)[TOP, 0] - rest(obj)[TOP, 0] - 2.0).max() < 1e-3


def test_controls_go_with_a_mesh_that_is_deleted(timers, part):
    obj, control = posed(timers)
    other, other_control = handles.tube("Other")
    kept = other_control.name
    meshes.activate(obj)
    name = control.name
    orphans = part("posing.bridge.orphans")
    assert not orphans.found()
    bpy.ops.object.delete()
    update()
    assert orphans.found()
    orphans.remove()
    assert name not in bpy.data.objects and kept in bpy.data.objects and not orphans.found()
    other.name = "Renamed"
    orphans.remove()
    assert kept in bpy.data.objects


@pytest.mark.parametrize("why", ["something else uses it", "it is animated", "it bears the name alone"])
def test_a_control_of_a_deleted_mesh_stays(timers, part, why):
    obj, control = posed(timers)
    name = control.name
    if why == "something else uses it":
        bpy.ops.object.camera_add()
        bpy.context.object.constraints.new('TRACK_TO').target = control
    elif why == "it is animated":
        control.keyframe_insert("location", frame=1)
    else:
        bpy.data.objects.remove(control)
    bpy.data.objects.remove(obj)
    if why == "it bears the name alone":
        meshes.new_object(name)
    update()
    part("posing.bridge.orphans").remove()
    assert name in bpy.data.objects
