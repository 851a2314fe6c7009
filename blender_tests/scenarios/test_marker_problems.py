# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems of a take: gaps, jumps and swapped markers, found and mended."""

import bpy
import numpy as np
import pytest
from support import steps, take_files
from support.marked_tube import FRAMES, LABELS, at_sample, match, recorded, set_up


def test_problems_are_listed_and_shown(tmp_path):
    positions = recorded()
    positions[25:, 4] += (0.0, 0.0, 3.0)
    positions[10:50, 9] = np.nan
    obj, take = set_up(tmp_path, positions)
    obj.meanvalue.capture.rigid_seconds = 0.2
    assert bpy.ops.meanvalue.find_marker_problems() == {'FINISHED'}
    problems = take.meanvalue.problems
    found = {(problem.marker.meanvalue.marker, round((problem.frame - 1.0) / 0.24)) for problem in problems}
    assert (LABELS[9], 10) in found and (LABELS[4], 25) in found
    index = next(number for number, each in enumerate(problems) if each.marker.meanvalue.marker == LABELS[4])
    take.meanvalue.active_problem = index
    assert bpy.context.scene.frame_current_final == pytest.approx(7.0)
    assert bpy.context.object.meanvalue.marker == LABELS[4]


def seen(take):
    """{marker: (f, 3)} float32 by sample, NaN where there is no key."""
    result = {}
    for empty in take.objects:
        result[empty.meanvalue.marker] = path = np.full((FRAMES, 3), np.nan, np.float32)
        for axis in range(3):
            keys = take_files.keys(empty, "location", axis)
            path[np.rint((keys[:, 0] - 1.0) / 0.24).astype(int), axis] = keys[:, 1]
    return result


def test_a_swapped_pair_is_found_and_mended(tmp_path):
    right = recorded()
    right[30:34, 4] = np.nan
    positions = right.copy()
    positions[25:, [4, 9]] = right[25:, [9, 4]]
    _obj, take = set_up(tmp_path, positions)
    assert bpy.ops.meanvalue.find_marker_problems() == {'FINISHED'}
    problems = take.meanvalue.problems
    pairs = [{each.marker.meanvalue.marker, each.other.meanvalue.marker} for each in problems if each.other]
    assert pairs == [{LABELS[4], LABELS[9]}]
    take.meanvalue.active_problem = next(k for k, each in enumerate(problems) if each.other)
    assert bpy.ops.meanvalue.swap_markers() == {'FINISHED'}
    assert not any(each.other for each in take.meanvalue.problems)
    for number, label in enumerate(LABELS):
        assert np.allclose(seen(take)[label], right[:, number], atol=1e-6, equal_nan=True), label
    at_sample(31.5)  # its presence goes along
    influence = {empty.meanvalue.marker: empty.meanvalue.influence for empty in take.objects}
    assert (influence[LABELS[4]], influence[LABELS[9]]) == (0.0, 1.0)
    assert bpy.ops.meanvalue.find_marker_problems() == {'FINISHED'}
    assert not any(each.other for each in take.meanvalue.problems)


def swap(take, one, other, frame):
    """As if Find Problems had found the two swapped from a frame on."""
    problem = take.meanvalue.problems.add()
    problem.marker, problem.other, problem.frame = take.objects[one], take.objects[other], frame
    take.meanvalue.active_problem = len(take.meanvalue.problems) - 1
    assert bpy.ops.meanvalue.swap_markers() == {'FINISHED'}


def test_markers_are_swapped_and_what_cannot_be_is_told(tmp_path):
    _obj, take = set_up(tmp_path)
    before = seen(take)
    one, other = LABELS[2], LABELS[7]
    swap(take, one, other, 1.0)
    after = seen(take)
    assert np.array_equal(after[one], before[other]) and np.array_equal(after[other], before[one])
    assert all(np.array_equal(after[label], before[label]) for label in LABELS if label not in (one, other))
    with steps.refused("Press Find Problems"):
        bpy.ops.meanvalue.swap_markers()
    with steps.refused("parents"):
        next(empty for empty in take.objects if empty.meanvalue.marker == one).parent = take.objects[0]
        swap(take, one, other, 1.0)
    assert np.array_equal(seen(take)[one], after[one])


def test_long_gaps_leave_the_handle_free_and_short_ones_are_filled(tmp_path):
    positions = recorded()
    positions[20:24, 3] = np.nan
    positions[30:50, 7] = np.nan
    obj, _take = set_up(tmp_path, positions)
    capture = obj.meanvalue.capture
    capture.rigid_seconds = 0.1
    match()
    filled, free = (capture.pairs[LABELS[number]].control for number in (3, 7))
    assert len(take_files.keys(filled, "meanvalue.influence")) == 0
    assert len(take_files.keys(filled, "location")) == FRAMES
    assert len(take_files.keys(free, "location")) == FRAMES - 20
    influence = []
    for sample in range(FRAMES):
        at_sample(sample)
        influence.append(free.meanvalue.influence)
    influence = np.array(influence)
    assert (influence[30:50] < 1e-4).all()
    # It fades over eight samples, which are the 0.08 s of marker_matching.
    assert (influence[:22] == 1.0).all() and influence[58:] == pytest.approx(1.0, abs=1e-3)
    assert (np.diff(influence[21:30]) < 0.0).all() and (np.diff(influence[50:58]) > 0.0).all()
    assert influence[29] < 0.001 and influence[50] < 0.001


def test_a_take_in_the_nla_with_a_marker_that_was_duplicated(tmp_path):
    """The strips are where the artist has put them, and the copy is no marker of the take."""
    obj, take = set_up(tmp_path)
    match()
    before = [take_files.keys(pair.control, "location") for pair in obj.meanvalue.capture.pairs]
    for empty in take.objects[:]:
        action, empty.animation_data.action = empty.animation_data.action, None
        empty.animation_data.nla_tracks.new().strips.new("Take", 21, action)
    twin = take.objects[LABELS[2]].copy()
    twin.animation_data_clear()
    take.objects.link(twin)
    obj.meanvalue.capture.reference_frame += 20
    match()
    after = [take_files.keys(pair.control, "location") for pair in obj.meanvalue.capture.pairs]
    for former, latter in zip(before, after, strict=True):
        assert np.allclose(np.add(former, (20.0, 0.0)), latter, atol=1e-4)
    one, other = (take.objects[LABELS[number]] for number in (2, 7))
    swap(take, LABELS[2], LABELS[7], 1.0)
    bpy.context.scene.frame_set(31)
    places = [tuple(each.location) for each in (one, other)]
    for each in (one, other):
        each.animation_data.action = None
    bpy.context.scene.frame_set(31)
    assert np.allclose(places, [tuple(each.location) for each in (other, one)], atol=1e-4)
