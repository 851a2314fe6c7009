# SPDX-License-Identifier: GPL-3.0-or-later
"""Match Markers: from a take to a mesh that follows it, and pairs corrected by hand."""

import bpy
import numpy as np
import pytest
from support import marked_tube as marked
from support import meshes, steps, take_files
from support.snapshot import assert_same, snapshot


def control_places(obj):
    return np.array([pair.control.matrix_world.translation for pair in obj.meanvalue.capture.pairs if pair.control])


def solved(obj):
    if not obj.meanvalue.bound.is_bound:
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.solve()
    return steps.key_positions(obj, "Mean-Value")


def size_of(obj):
    return float(np.linalg.norm(np.ptp(marked.rest_of(obj), axis=0)))


def counts():
    return {name: len(getattr(bpy.data, name)) for name in ("objects", "collections", "actions", "meshes")}


def test_every_marker_gets_a_soft_handle_of_its_own_vertex(tmp_path):
    obj, take = marked.set_up(tmp_path)
    meshes.duplicate(obj).parent = obj
    marked.match()
    assert max(empty.empty_display_size for empty in take.objects) < obj.meanvalue.handles[0].control.empty_display_size
    lines = obj.meanvalue.handles
    pairs = obj.meanvalue.capture.pairs
    assert [handle.name for handle in lines] == list(marked.LABELS) and len(obj.meanvalue.along) == 1
    assert [pair.vertex for pair in pairs] == marked.MARKED
    assert all((handle.follows, handle.is_soft, handle.strength) == ('CONTROL', True, 1.0) for handle in lines)
    assert [handle.control for handle in lines] == [pair.control for pair in pairs]
    assert all(pair.control.parent == obj for pair in pairs)
    assert all(pair.distance == pytest.approx(marked.OFF_SKIN, abs=1e-3) for pair in pairs)


def test_at_rest_in_the_reference_frame_and_followed_in_others(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    marked.at_sample(0)
    assert np.abs(control_places(obj) - marked.rest_of(obj)[marked.MARKED]).max() < 1e-5 * size_of(obj)
    assert np.abs(solved(obj) - marked.rest_of(obj)).max() < 1e-5 * size_of(obj)
    marked.at_sample(marked.FRAMES - 1)
    goal = marked.bent(marked.rest_of(obj), 1.0)
    off = np.linalg.norm(solved(obj) - goal, axis=1)
    moved = np.linalg.norm(goal - marked.rest_of(obj), axis=1).max()
    assert off[marked.MARKED].max() < 0.05 * moved, off[marked.MARKED].max() / moved
    assert off.max() < 0.15 * moved, off.max() / moved
    obj.meanvalue.live = True
    for sample, shape in ((0, marked.rest_of(obj)), (marked.FRAMES - 1, goal)):  # it follows at once
        marked.at_sample(sample)
        assert np.linalg.norm(steps.key_positions(obj, "Mean-Value") - shape, axis=1).max() < 0.15 * moved


@pytest.mark.parametrize("scale", [(2.0, 2.0, 2.0), (1.0, 1.5, 0.8)])
def test_a_moved_turned_and_scaled_object(tmp_path, scale):
    positions = marked.recorded()
    obj = meshes.tube(marked.RINGS, marked.SEGMENTS, "Tube")
    obj.location, obj.rotation_euler, obj.scale = (1.0, -2.0, 3.0), (0.4, 0.5, 0.6), scale
    bpy.context.view_layer.update()
    world = np.array(obj.matrix_world)
    positions = positions @ world[:3, :3].T + world[:3, 3]
    take = take_files.bring_in(take_files.write_trc(tmp_path / "bend.trc", marked.LABELS, positions), unit='METRES')
    obj.meanvalue.capture.align = 'NONE'
    obj.meanvalue.capture.reference_frame = 1.0
    marked.match()
    assert len(take.objects) == len(marked.LABELS)
    marked.at_sample(0)
    rest = marked.rest_of(obj)[marked.MARKED] @ world[:3, :3].T + world[:3, 3]
    assert np.abs(control_places(obj) - rest).max() < 1e-5 * size_of(obj) * max(scale)
    assert np.abs(solved(obj) - marked.rest_of(obj)).max() < 1e-5 * size_of(obj)


def test_by_picked_pairs_from_anywhere_at_any_size(tmp_path):
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    away = 0.37 * marked.recorded() @ turn.T + (5.0, 6.0, 0.5)
    obj, _take = marked.set_up(tmp_path, away, align='PICKED')
    for name, number in (("M0", 0), ("M2", 1)):
        assert bpy.ops.meanvalue.pick_marker_point(marker=name, vertex=marked.MARKED[number]) == {'FINISHED'}
    with steps.refused("at least 3 markers", unchanged=obj):
        bpy.ops.meanvalue.match_markers()
    for number in (6, 12, 17, 19):
        picked = {"marker": marked.LABELS[number], "vertex": marked.MARKED[number]}
        assert bpy.ops.meanvalue.pick_marker_point(**picked) == {'FINISHED'}
    marked.match()
    assert [pair.vertex for pair in obj.meanvalue.capture.pairs] == marked.MARKED
    marked.at_sample(0)
    assert np.abs(control_places(obj) - marked.rest_of(obj)[marked.MARKED]).max() < 1e-4 * size_of(obj)


def test_matching_again_does_not_pile_up(tmp_path):
    obj, take = marked.set_up(tmp_path)
    steps.add_handle(obj, "Own", [3, 5], pin=True)
    curves = [take_files.keys(empty, "location", 1).tobytes() for empty in take.objects]
    marked.match()
    obj.meanvalue.handles["M0"].strength = 0.25
    first, control = counts(), obj.meanvalue.capture.pairs[0].control.name
    for _ in range(2):
        marked.match()
        assert counts() == first
    assert [handle.name for handle in obj.meanvalue.handles] == ["Own", *marked.LABELS]
    assert obj.meanvalue.handles["Own"].follows == 'REST'
    assert obj.meanvalue.handles["M0"].strength == 0.25
    assert obj.meanvalue.capture.pairs[0].control.name == control
    assert [take_files.keys(empty, "location", 1).tobytes() for empty in take.objects] == curves
    assert obj.vertex_groups.keys() == ["Own"]


def test_a_reference_from_another_take(tmp_path):
    positions = marked.recorded()
    obj, _take = marked.set_up(tmp_path, positions[20:])
    capture = obj.meanvalue.capture
    for name, labels in (("others", [f"Q{label}" for label in marked.LABELS]), ("standing", marked.LABELS)):
        path = take_files.write_trc(tmp_path / f"{name}.trc", labels, positions[:3])
        capture.reference_take = take_files.bring_in(path, unit='METRES')
        if name == "others":
            with steps.refused("Choose another Reference Take"):
                marked.match()
    marked.match()
    assert [pair.vertex for pair in capture.pairs] == marked.MARKED
    marked.at_sample(marked.FRAMES - 21)
    goal = marked.bent(marked.rest_of(obj), 1.0)[marked.MARKED]
    assert np.linalg.norm(control_places(obj) - goal, axis=1).max() < 0.06


def test_a_picked_point_is_kept_and_one_marker_has_one_vertex(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    names = [name for name in marked.LABELS if name != "M4"]
    others = [take_files.keys(obj.meanvalue.capture.pairs[name].control, "location").tobytes() for name in names]
    with steps.refused("carries marker 'M2' already"):
        bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=2)
    assert bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=5) == {'FINISHED'}
    pair = obj.meanvalue.capture.pairs["M4"]
    assert (pair.vertex, pair.is_picked) == (5, True)
    marked.at_sample(0)
    assert np.abs(np.array(pair.control.matrix_world.translation) - marked.rest_of(obj)[5]).max() < 1e-5 * size_of(obj)
    assert np.abs(solved(obj) - marked.rest_of(obj)).max() < 1e-5 * size_of(obj)
    capture = obj.meanvalue.capture
    assert [take_files.keys(capture.pairs[name].control, "location").tobytes() for name in names] == others
    marked.match()
    assert obj.meanvalue.capture.pairs["M4"].vertex == 5
    assert len({pair.vertex for pair in obj.meanvalue.capture.pairs}) == len(marked.LABELS)


def test_removing_a_marker_and_having_it_back(tmp_path):
    obj, take = marked.set_up(tmp_path)
    marked.match()
    before = counts()
    assert bpy.ops.meanvalue.pick_marker_point(marker="M36", remove=True) == {'FINISHED'}
    capture = obj.meanvalue.capture
    assert "M36" not in obj.meanvalue.handles
    assert capture.pairs["M36"].control is None and not capture.pairs["M36"].is_used
    assert len(take.objects) == len(marked.LABELS)
    assert counts() == {**before, "objects": before["objects"] - 1, "actions": before["actions"] - 1}
    marked.match()
    assert "M36" not in obj.meanvalue.handles
    capture.pairs["M36"].is_used = True
    marked.match()
    assert counts() == before and "M36" in obj.meanvalue.handles


def test_controls_that_were_deleted_are_made_again(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    before = counts()
    bpy.data.objects.remove(obj.meanvalue.capture.pairs[4].control)
    other = obj.meanvalue.capture.pairs[5].control
    for collection in other.users_collection:
        collection.objects.unlink(other)
    marked.match()
    assert len(control_places(obj)) == len(marked.LABELS) and len(obj.meanvalue.handles) == len(marked.LABELS)
    assert all(pair.control.users_scene for pair in obj.meanvalue.capture.pairs)
    marked.at_sample(0)
    assert np.abs(control_places(obj) - marked.rest_of(obj)[marked.MARKED]).max() < 1e-5 * size_of(obj)
    assert counts()["collections"] == before["collections"]


def test_a_duplicate_gets_controls_of_its_own(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    before = [pair.control.name for pair in obj.meanvalue.capture.pairs]
    twin = meshes.duplicate(obj, name="Twin")
    meshes.activate(twin)
    marked.match()
    assert [pair.control.name for pair in obj.meanvalue.capture.pairs] == before
    assert all(pair.control.parent == twin for pair in twin.meanvalue.capture.pairs)
    assert len(twin.meanvalue.handles) == len(marked.LABELS)


def test_a_handle_that_was_given_another_control_is_the_artists(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    own = meshes.new_object("Own")
    obj.meanvalue.handles["M0"].control = own
    marked.match()
    assert obj.meanvalue.handles["M0"].control == own
    assert obj.meanvalue.capture.pairs["M0"].control not in {own, None}


def test_one_undo_takes_the_match_back(tmp_path):
    obj, _take = marked.set_up(tmp_path)
    bpy.ops.ed.undo_push(message="Before")
    before = snapshot(obj), counts()
    marked.match()
    bpy.ops.ed.undo_push(message="Match")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert_same(before[0], snapshot(obj))
    assert counts() == before[1]


def test_wrong_input_is_refused_and_changes_nothing(tmp_path):
    obj = meshes.tube(marked.RINGS, marked.SEGMENTS, "Tube")
    with steps.refused("No take is chosen", "Import"):
        bpy.ops.meanvalue.match_markers()
    with steps.refused("has no markers yet"):
        bpy.ops.meanvalue.pick_marker_point(vertex=3)
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    obj, take = marked.set_up(tmp_path)
    before = snapshot(obj)
    with steps.refused("none of the 136 vertices"):
        bpy.ops.meanvalue.pick_marker_point(marker="M0", vertex=136)
    with steps.refused("'Elbow' is no marker"):
        bpy.ops.meanvalue.pick_marker_point(marker="Elbow", vertex=1)
    obj.meanvalue.capture.use_low_pass, obj.meanvalue.capture.cutoff_hz = True, 50.0
    with steps.refused("half the frame rate"):
        bpy.ops.meanvalue.match_markers()
    obj.meanvalue.capture.use_low_pass, obj.meanvalue.capture.cutoff_hz = False, 6.0
    for pair in obj.meanvalue.capture.pairs:
        pair.is_used = False
    with steps.refused("No marker is ticked"):
        bpy.ops.meanvalue.match_markers()
    for pair in obj.meanvalue.capture.pairs:
        pair.is_used = True
    assert_same(before, snapshot(obj))
    for empty in list(take.objects):
        empty.animation_data_clear()
    with steps.refused("no markers with keyframes"):
        bpy.ops.meanvalue.match_markers()


@pytest.mark.parametrize("edit", ["mesh", "keys"])
def test_what_was_edited_meanwhile_is_not_written_over(tmp_path, monkeypatch, part, edit):
    obj, _take = marked.set_up(tmp_path)
    marked.match()
    matching, control = part("capture.bridge.marker_matching"), obj.meanvalue.handles[3].control
    find = matching.steps

    def edited(given):
        if edit == "mesh":
            obj.data.vertices[5].co.x += 0.1
        else:
            control.keyframe_insert("location", frame=40)
        return find(given)

    monkeypatch.setattr(matching, "steps", edited)
    with steps.refused("was changed while it was worked on"):
        marked.match()
    assert edit == "mesh" or take_files.keys(control, "location")[-1, 0] == 40
