# SPDX-License-Identifier: GPL-3.0-or-later
"""Match Markers: from a take to a mesh that follows it, and pairs corrected by hand.

The take is made of the mesh itself: some of its vertices, bent as a whole, a little off the surface.
"""

import bpy
import numpy as np
import pytest
from support import meshes, steps, take_files
from support.snapshot import assert_same, snapshot

RINGS, SEGMENTS = 17, 8
#: Of the tube: every fourth ring, every other vertex.
MARKED = [ring * SEGMENTS + segment for ring in range(0, RINGS, 4) for segment in range(0, SEGMENTS, 2)]
LABELS = tuple(f"M{vertex}" for vertex in MARKED)
FRAMES = 60
OFF_SKIN = 0.05


def rest_of(obj):
    return np.array([vertex.co for vertex in obj.data.vertices])


def bent(points, share):
    """The tube bent about its foot, by `share` of a third of a turn at its top."""
    height = rest_top(points)
    angle = share * 1.0 * points[:, 2] / height
    result = points.copy()
    result[:, 0] = points[:, 0] * np.cos(angle) + points[:, 2] * np.sin(angle)
    result[:, 2] = points[:, 2] * np.cos(angle) - points[:, 0] * np.sin(angle)
    return result


def rest_top(points):
    return 0.6 * (RINGS - 1)


def recorded():
    """(f, m, 3): markers off the skin of the bending tube. In the first sample it stands as the mesh does."""
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    marked = rest_of(obj)[MARKED]
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    outwards = marked * (1.0, 1.0, 0.0)
    markers = marked + OFF_SKIN * outwards / np.linalg.norm(outwards, axis=1, keepdims=True)
    return np.stack([bent(markers, frame / (FRAMES - 1)) for frame in range(FRAMES)])


def set_up(tmp_path, positions=None, align='NONE', **options):
    """(tube, take) with the take chosen."""
    positions = recorded() if positions is None else positions
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    path = take_files.write_trc(tmp_path / "bend.trc", LABELS, positions)
    take = take_files.bring_in(path, unit='METRES', **options)
    capture = obj.meanvalue.capture
    capture.align = align
    capture.reference_frame = 1.0
    assert capture.take == take
    return obj, take


def match():
    assert bpy.ops.meanvalue.match_markers() == {'FINISHED'}


def at_sample(sample, start=1.0):
    frame = start + 0.24 * sample
    whole = int(np.floor(frame))
    bpy.context.scene.frame_set(whole, subframe=float(frame - whole))


def control_places(obj):
    return np.array([pair.control.matrix_world.translation for pair in obj.meanvalue.capture.pairs if pair.control])


def solved(obj):
    if not obj.meanvalue.bound.is_bound:
        assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    steps.solve()
    return steps.key_positions(obj, "Mean-Value")


def size_of(obj):
    return float(np.linalg.norm(np.ptp(rest_of(obj), axis=0)))


def counts():
    return {name: len(getattr(bpy.data, name)) for name in ("objects", "collections", "actions", "meshes")}


def test_every_marker_gets_a_soft_handle_of_its_own_vertex(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    lines = obj.meanvalue.handles
    pairs = obj.meanvalue.capture.pairs
    assert [line.name for line in lines] == list(LABELS)
    assert [pair.vertex for pair in pairs] == MARKED
    assert all((line.follows, line.is_soft, line.strength) == ('CONTROL', True, 1.0) for line in lines)
    assert [line.control for line in lines] == [pair.control for pair in pairs]
    assert all(pair.control.parent == obj for pair in pairs)
    assert all(pair.distance == pytest.approx(OFF_SKIN, abs=1e-3) for pair in pairs)


def test_at_the_reference_frame_the_shape_is_at_rest_and_at_others_the_anchors_follow(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    at_sample(0)
    assert np.abs(control_places(obj) - rest_of(obj)[MARKED]).max() < 1e-5 * size_of(obj)
    assert np.abs(solved(obj) - rest_of(obj)).max() < 1e-5 * size_of(obj)
    at_sample(FRAMES - 1)
    goal = bent(rest_of(obj), 1.0)
    off = np.linalg.norm(solved(obj) - goal, axis=1)
    moved = np.linalg.norm(goal - rest_of(obj), axis=1).max()
    assert off[MARKED].max() < 0.05 * moved, off[MARKED].max() / moved
    assert off.max() < 0.15 * moved, off.max() / moved


def test_live_follows_at_once_when_the_frame_is_changed(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    obj.meanvalue.live = True
    at_sample(FRAMES - 1)
    moved = np.linalg.norm(bent(rest_of(obj), 1.0) - rest_of(obj), axis=1).max()
    shown = steps.key_positions(obj, "Mean-Value")
    assert np.linalg.norm(shown - bent(rest_of(obj), 1.0), axis=1).max() < 0.15 * moved


@pytest.mark.parametrize("scale", [(2.0, 2.0, 2.0), (1.0, 1.5, 0.8)])
def test_a_moved_turned_and_scaled_object(tmp_path, scale):
    positions = recorded()
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    obj.location, obj.rotation_euler, obj.scale = (1.0, -2.0, 3.0), (0.4, 0.5, 0.6), scale
    bpy.context.view_layer.update()
    world = np.array(obj.matrix_world)
    positions = positions @ world[:3, :3].T + world[:3, 3]
    take = take_files.bring_in(take_files.write_trc(tmp_path / "bend.trc", LABELS, positions), unit='METRES')
    obj.meanvalue.capture.align = 'NONE'
    obj.meanvalue.capture.reference_frame = 1.0
    match()
    assert len(take.objects) == len(LABELS)
    at_sample(0)
    rest = rest_of(obj)[MARKED] @ world[:3, :3].T + world[:3, 3]
    assert np.abs(control_places(obj) - rest).max() < 1e-5 * size_of(obj) * max(scale)
    assert np.abs(solved(obj) - rest_of(obj)).max() < 1e-5 * size_of(obj)


def test_by_picked_pairs_from_anywhere_at_any_size(tmp_path):
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    away = 0.37 * recorded() @ turn.T + (5.0, 6.0, 0.5)
    obj, _take = set_up(tmp_path, away, align='PICKED')
    for name, number in (("M0", 0), ("M2", 1)):
        assert bpy.ops.meanvalue.pick_marker_point(marker=name, vertex=MARKED[number]) == {'FINISHED'}
    before = snapshot(obj)
    with steps.refused("at least 3 markers", "2 markers have one"):
        bpy.ops.meanvalue.match_markers()
    assert_same(before, snapshot(obj))
    for number in (6, 12, 17, 19):
        assert bpy.ops.meanvalue.pick_marker_point(marker=LABELS[number], vertex=MARKED[number]) == {'FINISHED'}
    match()
    assert [pair.vertex for pair in obj.meanvalue.capture.pairs] == MARKED
    at_sample(0)
    assert np.abs(control_places(obj) - rest_of(obj)[MARKED]).max() < 1e-4 * size_of(obj)


def test_matching_again_does_not_pile_up(tmp_path):
    obj, take = set_up(tmp_path)
    steps.add_group(obj, "Own", [3, 5])
    assert bpy.ops.meanvalue.add_handle(pin=True, group="Own") == {'FINISHED'}
    curves = [take_files.keys(empty, "location", 1).tobytes() for empty in take.objects]
    match()
    obj.meanvalue.handles["M0"].strength = 0.25
    first, control = counts(), obj.meanvalue.capture.pairs[0].control.name
    for _ in range(2):
        match()
        assert counts() == first
    assert [line.name for line in obj.meanvalue.handles] == ["Own", *LABELS]
    assert obj.meanvalue.handles["Own"].follows == 'REST'
    assert obj.meanvalue.handles["M0"].strength == 0.25
    assert obj.meanvalue.capture.pairs[0].control.name == control
    assert [take_files.keys(empty, "location", 1).tobytes() for empty in take.objects] == curves
    assert len(obj.vertex_groups) == 1 + len(LABELS)


def test_long_gaps_leave_the_handle_free_and_short_ones_are_filled(tmp_path):
    positions = recorded()
    positions[20:24, 3] = np.nan
    positions[30:50, 7] = np.nan
    obj, _take = set_up(tmp_path, positions)
    capture = obj.meanvalue.capture
    capture.spline_seconds, capture.rigid_seconds = 0.1, 0.1
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


def test_the_low_pass_takes_off_noise(tmp_path):
    clean = recorded()
    noisy = clean + 0.02 * np.random.default_rng(5).standard_normal(clean.shape)
    obj, _take = set_up(tmp_path, noisy)

    def roughness():
        match()
        values = [take_files.keys(pair.control, "location", 0)[:, 1] for pair in obj.meanvalue.capture.pairs]
        return float(np.abs(np.diff(values, 2, axis=1)).mean())

    rough = roughness()
    obj.meanvalue.capture.use_low_pass = True
    assert roughness() < 0.3 * rough


def test_a_reference_from_another_take(tmp_path):
    positions = recorded()
    obj, _take = set_up(tmp_path, positions[20:])
    path = take_files.write_trc(tmp_path / "standing.trc", LABELS, positions[:3])
    standing = take_files.bring_in(path, unit='METRES')
    capture = obj.meanvalue.capture
    capture.reference_take = standing
    match()
    assert [pair.vertex for pair in capture.pairs] == MARKED
    at_sample(FRAMES - 21)
    goal = bent(rest_of(obj), 1.0)
    assert np.linalg.norm(control_places(obj) - goal[MARKED], axis=1).max() < 0.06


def test_a_picked_point_is_kept_and_one_marker_has_one_vertex(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    names = [name for name in LABELS if name != "M4"]
    others = [take_files.keys(obj.meanvalue.capture.pairs[name].control, "location").tobytes() for name in names]
    with steps.refused("carries marker 'M2' already"):
        bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=2)
    assert bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=5) == {'FINISHED'}
    pair = obj.meanvalue.capture.pairs["M4"]
    assert (pair.vertex, pair.is_picked) == (5, True)
    at_sample(0)
    assert np.abs(np.array(pair.control.matrix_world.translation) - rest_of(obj)[5]).max() < 1e-5 * size_of(obj)
    assert np.abs(solved(obj) - rest_of(obj)).max() < 1e-5 * size_of(obj)
    capture = obj.meanvalue.capture
    assert [take_files.keys(capture.pairs[name].control, "location").tobytes() for name in names] == others
    match()
    assert obj.meanvalue.capture.pairs["M4"].vertex == 5
    assert len({pair.vertex for pair in obj.meanvalue.capture.pairs}) == len(LABELS)


def test_picking_a_vertex_of_an_unpicked_neighbour_moves_that_one_away(tmp_path):
    obj, _take = set_up(tmp_path)
    assert bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=2) == {'FINISHED'}
    match()
    pairs = obj.meanvalue.capture.pairs
    assert pairs["M4"].vertex == 2
    assert pairs["M2"].vertex != 2
    assert len({pair.vertex for pair in pairs}) == len(LABELS)


def test_removing_a_marker_and_having_it_back(tmp_path):
    obj, take = set_up(tmp_path)
    match()
    before = counts()
    assert bpy.ops.meanvalue.pick_marker_point(marker="M36", remove=True) == {'FINISHED'}
    capture = obj.meanvalue.capture
    assert "M36" not in obj.meanvalue.handles and "M36" not in obj.vertex_groups
    assert capture.pairs["M36"].control is None and not capture.pairs["M36"].is_used
    assert len(take.objects) == len(LABELS)
    assert counts() == {**before, "objects": before["objects"] - 1, "actions": before["actions"] - 1}
    match()
    assert "M36" not in obj.meanvalue.handles
    capture.pairs["M36"].is_used = True
    match()
    assert counts() == before and "M36" in obj.meanvalue.handles


def test_the_line_that_is_chosen_is_selected(tmp_path):
    obj, take = set_up(tmp_path)
    obj.meanvalue.capture.active_pair = 2
    assert bpy.context.object == take.objects[2]
    match()
    obj.meanvalue.capture.active_pair = 3
    assert bpy.context.object == obj.meanvalue.capture.pairs[3].control
    bpy.context.view_layer.update()
    assert obj.meanvalue.active_handle == 3
    assert bpy.ops.meanvalue.pick_marker_point(vertex=7) == {'FINISHED'}  # of the active control
    assert obj.meanvalue.capture.pairs[3].vertex == 7


def test_controls_that_were_deleted_are_made_again(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    before = counts()
    bpy.data.objects.remove(obj.meanvalue.capture.pairs[4].control)
    other = obj.meanvalue.capture.pairs[5].control
    for collection in other.users_collection:
        collection.objects.unlink(other)
    match()
    assert len(control_places(obj)) == len(LABELS) and len(obj.meanvalue.handles) == len(LABELS)
    assert all(pair.control.users_scene for pair in obj.meanvalue.capture.pairs)
    at_sample(0)
    assert np.abs(control_places(obj) - rest_of(obj)[MARKED]).max() < 1e-5 * size_of(obj)
    assert counts()["collections"] == before["collections"]


def test_a_duplicate_gets_controls_of_its_own(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    before = [pair.control.name for pair in obj.meanvalue.capture.pairs]
    twin = obj.copy()
    twin.data = obj.data.copy()
    twin.name = "Twin"
    bpy.context.collection.objects.link(twin)
    meshes.activate(twin)
    match()
    assert [pair.control.name for pair in obj.meanvalue.capture.pairs] == before
    assert all(pair.control.parent == twin for pair in twin.meanvalue.capture.pairs)
    assert len(twin.meanvalue.handles) == len(LABELS)


def test_a_handle_that_was_given_another_control_is_the_artists(tmp_path):
    obj, _take = set_up(tmp_path)
    match()
    own = bpy.data.objects.new("Own", None)
    bpy.context.collection.objects.link(own)
    obj.meanvalue.handles["M0"].control = own
    match()
    assert obj.meanvalue.handles["M0"].control == own
    assert obj.meanvalue.capture.pairs["M0"].control not in {own, None}


def test_one_undo_takes_the_match_back(tmp_path):
    obj, _take = set_up(tmp_path)
    bpy.ops.ed.undo_push(message="Before")
    before = snapshot(obj), counts()
    match()
    bpy.ops.ed.undo_push(message="Match")
    bpy.ops.ed.undo()
    obj = bpy.data.objects["Tube"]
    assert_same(before[0], snapshot(obj))
    assert counts() == before[1]


def test_wrong_input_is_refused_and_changes_nothing(tmp_path):
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    with steps.refused("No take is chosen", "Import"):
        bpy.ops.meanvalue.match_markers()
    with steps.refused("has no markers yet"):
        bpy.ops.meanvalue.pick_marker_point(vertex=3)
    bpy.data.objects.remove(obj)
    bpy.context.view_layer.update()
    obj, take = set_up(tmp_path)
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


def test_markers_are_swapped_in_the_whole_take_and_what_cannot_be_is_told(tmp_path):
    _obj, take = set_up(tmp_path)
    before = seen(take)
    one, other = LABELS[2], LABELS[7]
    assert bpy.ops.meanvalue.swap_markers(marker=one, other=other, whole_take=True) == {'FINISHED'}
    after = seen(take)
    assert np.array_equal(after[one], before[other]) and np.array_equal(after[other], before[one])
    assert all(np.array_equal(after[label], before[label]) for label in LABELS if label not in (one, other))
    with steps.refused("Press Find Problems"):
        bpy.ops.meanvalue.swap_markers()
    with steps.refused("'Nose' is no marker"):
        bpy.ops.meanvalue.swap_markers(marker=one, other="Nose")
    with steps.refused("itself"):
        bpy.ops.meanvalue.swap_markers(marker=one, other=one)
    with steps.refused("parents"):
        next(empty for empty in take.objects if empty.meanvalue.marker == one).parent = take.objects[0]
        bpy.ops.meanvalue.swap_markers(marker=one, other=other)
    assert np.array_equal(seen(take)[one], after[one])


def test_a_clean_take_has_no_problems(tmp_path):
    obj, take = set_up(tmp_path)
    assert bpy.ops.meanvalue.find_marker_problems() == {'FINISHED'}
    assert len(take.meanvalue.problems) == 0 and take.meanvalue.is_searched
    assert obj.meanvalue.capture.take == take


def test_lines_go_from_each_marker_to_its_point(tmp_path, part):
    obj, _take = set_up(tmp_path)
    lines = part("capture.bridge.pair_lines")
    assert len(lines.lines(obj).ends) == 0
    match()
    found = lines.lines(obj)
    ends = found.ends.reshape(-1, 2, 3)
    assert np.allclose(ends[:, 0], rest_of(obj)[MARKED], atol=1e-6)
    assert np.allclose(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1), OFF_SKIN, atol=1e-3)
    near, far = lines.distance_colors([0.0, 1.0])
    assert near[1] > near[0] and far[0] > far[1]
    obj.meanvalue.capture.show_pairs = False
    assert len(lines.lines(obj).ends) == 0


def told(capfd, **settings):
    """What Match says with these settings of Motion Capture."""
    for name, value in settings.items():
        setattr(bpy.context.object.meanvalue.capture, name, value)
    capfd.readouterr()
    match()
    return capfd.readouterr().out


def test_what_is_to_be_done_next_is_what_the_panel_says(tmp_path, capfd, part):
    obj, _take = set_up(tmp_path)
    text = told(capfd)
    assert part("posing.bridge.object_status").status(obj).text in text, text
    obj.meanvalue.live = True
    assert "press Live" not in told(capfd)
    obj.meanvalue.live = False
    obj.meanvalue.baked.target = 'POINT_CACHE'
    text = told(capfd)
    assert "A bake plays" in text and "press Live" not in text, text


def test_what_could_be_better_is_told(tmp_path, capfd):
    obj, _take = set_up(tmp_path)
    assert "is known of 0" in told(capfd, align='AUTO')
    assert "is known of 0" not in told(capfd, align='NONE')
    assert "lengths are as captured" in told(capfd, mode='RETARGET')
    assert bpy.ops.meanvalue.pick_marker_point(marker="M4", vertex=5) == {'FINISHED'}
    meshes.activate(obj)
    assert "lengths are as captured" not in told(capfd)
    steps.add_group(obj, "Foot", [0, 1, 2])
    assert bpy.ops.meanvalue.add_handle(pin=True, group="Foot") == {'FINISHED'}
    assert "'M0' and 'M2' belong to vertices that 'Foot' has too" in told(capfd, mode='AS_CAPTURED')
    obj.meanvalue.method = 'paper'
    assert "need the method Fast" in told(capfd)


@pytest.mark.parametrize(("frame", "is_told"), [(5000.0, True), (-40.0, True), (1.0, False), (7.3, False)])
def test_a_reference_frame_that_the_take_has_not_is_told(tmp_path, capfd, frame, is_told):
    obj, _take = set_up(tmp_path)
    text = told(capfd, reference_frame=frame)
    assert (f"has no frame {frame:g}" in text) == is_told, text
    if is_told:
        assert f"Frame {obj.meanvalue.capture.reference_frame:g} was taken" in text, text


#: Where joints of a tube that stands for a body are, of its height: sideways, to the front, up.
SKELETON = {
    "Hips": (0.0, 0.0, 0.55), "Neck": (0.0, 0.0, 0.85), "Jaw": (0.0, -0.02, 0.9), "Head": (0.0, 0.0, 0.9),
    **{f"{word}{name}": (sign * x, 0.0, z) for word, sign in (("Left", 1.0), ("Right", -1.0)) for name, x, z in (
        ("UpLeg", 0.03, 0.5), ("Leg", 0.03, 0.28), ("Foot", 0.03, 0.05), ("Arm", 0.05, 0.8), ("ForeArm", 0.05, 0.65),
        ("Hand", 0.05, 0.5),
    )},
}  # fmt: skip


def test_of_a_skeleton_joints_without_a_place_get_no_handle(tmp_path, capfd):
    places = rest_top(None) * np.array(list(SKELETON.values()))
    obj = meshes.tube(RINGS, SEGMENTS, "Tube")
    path = take_files.write_trc(tmp_path / "walk.trc", tuple(SKELETON), np.repeat(places[None], 5, axis=0))
    take_files.bring_in(path, unit='METRES')
    text = told(capfd, align='NONE')
    assert [line.name for line in obj.meanvalue.handles] == [name for name in SKELETON if name != "Jaw"]
    assert "1 joint of the skeleton, 'Jaw', has no known place" in text and "15 of 16 names known" in text, text
    assert bpy.ops.meanvalue.pick_marker_point(marker="Jaw", vertex=100) == {'FINISHED'}
    match()
    assert "Jaw" in obj.meanvalue.handles
