# SPDX-License-Identifier: GPL-3.0-or-later
"""A rig that moves is no edit: nothing is read again. What is edited is still found."""

import bpy
import numpy as np
import pytest
from support import handles, rigged
from support.handles import TOP, update


@pytest.fixture
def reads(part, monkeypatch):
    """A list that grows with every slice of vertex weights that is read, and every gathering of the scene."""
    counted = []
    reading, module = part("scene.vertex_groups").Reading, part("posing.bridge.scene_input")
    go_on, gather = reading.go_on, module.gather
    monkeypatch.setattr(reading, "go_on", lambda *arguments: counted.append("weights") or go_on(*arguments))
    monkeypatch.setattr(module, "gather", lambda *arguments: counted.append("scene") or gather(*arguments))
    return counted


def test_bone_steps_read_nothing(part, reads):
    obj, rig = rigged.tube(live=True)
    update()
    assert part("posing.bridge.object_status").status(obj).state.name == "BOUND"
    model = part("scene.object_model").of(obj)
    revisions, stamp = [model.rig_revision], model.stamp
    reads.clear()
    for step in range(10):
        rigged.bend(rig, 5.0 * step + 5.0)
        update()
        part("posing.bridge.object_status").status(obj)
        revisions.append(part("scene.object_model").rig_revision(obj))
    assert reads == []
    assert model.stamp == stamp
    assert len(set(revisions)) == 11 and revisions == sorted(revisions)


def test_a_doubt_is_not_looked_into_while_bones_move(part, reads):
    """As the interface has it: handlers only follow, the timer reads when all is quiet."""
    obj, rig = rigged.tube()
    follower = part("posing.live.follower").Follower(obj, hears_itself=True)
    while not follower.is_resting:
        follower.tick(obj)
    while follower.tick(obj) is not None:
        pass
    model = part("scene.object_model").of(obj)
    model.doubt()
    reads.clear()
    for step in range(10):
        rigged.bend(rig, 5.0 * step + 5.0)
        update()
        follower.follow(obj)
    assert reads == [] and model.is_doubtful
    while follower.tick(obj) is not None:
        pass
    assert reads != [] and not model.is_doubtful
    follower.stop()


def test_moving_the_object_reads_nothing(part, reads):
    obj, _control = handles.tube()
    reads.clear()
    for _step in range(5):
        obj.location.x += 0.5
        update()
    assert reads == []


def test_a_drag_of_a_control_is_no_move_of_the_rig(part):
    obj, _rig = rigged.tube(live=True)
    before = part("scene.object_model").rig_revision(obj)
    handles.move(obj.meanvalue.handles["Top"].control, (1.0, 0.0, 0.0))
    assert np.abs(handles.shown(obj)[TOP, 0] - handles.rest(obj)[TOP, 0] - 1.0).max() < 1e-3
    assert part("scene.object_model").rig_revision(obj) == before


def test_what_is_edited_beside_a_bone_step_is_found(part):
    obj, rig = rigged.tube(live=True)
    obj.vertex_groups["Top"].remove([TOP[0], TOP[1]])
    rigged.bend(rig, 20.0)
    update()
    assert part("scene.object_model").of(obj).bind_input(obj).anchors.size == 14
    basis = obj.data.shape_keys.reference_key
    basis.data[TOP[2]].co.x += 0.25
    rigged.bend(rig, 40.0)
    update()
    rest = part("scene.object_model").of(obj)
    rest.read_on(obj)
    assert rest.bind_input(obj).rest[TOP[2], 0] == pytest.approx(basis.data[TOP[2]].co.x)


def test_a_script_that_writes_the_rest_shape_in_bulk_is_noticed(part):
    """Later Blenders tell of it as of a driven slider."""
    obj, _control = handles.tube()
    status = part("live.engine").status
    assert not status(obj)[1]
    basis = obj.data.shape_keys.reference_key
    store, attribute = part("compat").key_store(basis)
    shape = np.empty(3 * len(store), np.float32)
    store.foreach_get(attribute, shape)
    store.foreach_set(attribute, 1.5 * shape)
    if not part("compat").points_tell_as_sliders(basis):
        obj.data.shape_keys.update_tag()
    update()
    text, is_problem = status(obj)
    assert is_problem and "rest shape" in text


def test_every_change_of_state_is_one_of_those_that_are_written_down(part, monkeypatch):
    states, following = part("live.states"), part("live.following").Following
    passed = []

    def remember(follower, state):
        passed.append((vars(follower).get("state", states.State.READING), state))
        vars(follower)["state"] = state

    monkeypatch.setattr(following, "state", property(lambda each: vars(each)["state"], remember), raising=False)
    obj, control = handles.tube()
    for step in range(3):
        handles.move(control, (0.3, 0.0, 0.1 * step))
    obj.vertex_groups["Top"].remove([TOP[0]])
    update()
    handles.move(control, (0.1, 0.0, 0.0))
    bpy.ops.object.select_all(action='DESELECT')
    line = obj.meanvalue.handles["Top"]
    line.control = None
    update()
    line.control = control
    update()
    obj.meanvalue.handles["Bottom"].name = "Nowhere"
    update()
    obj.meanvalue.handles["Nowhere"].name = "Bottom"
    update()
    obj.meanvalue.live = False
    obj.shape_key_add(name="Bend", from_mix=False)
    obj.meanvalue.mix.is_on = True
    update()
    obj.data.shape_keys.key_blocks["Bend"].value = 0.5
    update()
    wrong = {pair for pair in passed if pair[0] is not pair[1] and not states.may_follow(*pair)}
    assert not wrong, wrong
    reached = {after.name for _before, after in passed}
    assert reached >= {"READING", "BINDING", "SOLVING", "SHOWN", "SETTLING", "SETTLED", "WAITING", "BLOCKED"}
