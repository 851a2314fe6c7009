# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing half a mesh below a Mirror modifier: the seam stays closed."""

import pathlib

import bpy
import numpy as np
import pytest
from support import halves, meshes, steps
from support.baking import rows
from support.halves import move, rest, shown, turn, update

#: In the object's own units; the bodies are 4 high.
CLOSED = 1e-6


def opening(obj, axis=0, shape=None):
    return float(np.abs((shown(obj) if shape is None else shape)[halves.seam(obj, axis), axis]).max())


@pytest.mark.parametrize("merge, clip", [(True, True), (False, False)])
def test_the_seam_stays_closed_while_a_handle_is_dragged(merge, clip):
    obj, control = halves.half(merge=merge, clip=clip)
    plain = len(meshes.seen(obj))
    for step in range(6):
        move(control, (0.05, 0.12, 0.1))
        turn(control, 0.15)
        assert opening(obj) < CLOSED, step
    slid = (shown(obj) - rest(obj))[halves.seam(obj)]
    assert np.abs(slid[:, 1:]).max() > 0.3
    assert len(meshes.seen(obj)) == plain  # what was merged still is


@pytest.mark.parametrize("axes", [(1,), (0, 1), (0, 1, 2)])
def test_other_axes_and_several(axes):
    obj, control = halves.half(axes)
    move(control, (0.1, 0.2, 0.3))
    turn(control, 0.4)
    for axis in axes:
        assert opening(obj, axis) < CLOSED
    assert np.abs(shown(obj) - rest(obj)).max() > 0.2


def test_a_seam_that_is_not_quite_in_the_plane_is_merged_all_the_same():
    """Each vertex within the merge distance; they keep the little that they are off."""
    obj, control = halves.half(shift=(2e-4, 0.0, 0.0))
    plain = len(meshes.seen(obj))
    edge = np.flatnonzero(np.abs(rest(obj)[:, 0]) < 3e-4)
    turn(control, 0.5)
    move(control, (0.1, 0.3, 0.1))
    assert np.abs(shown(obj)[edge, 0] - rest(obj)[edge, 0]).max() < CLOSED
    assert len(meshes.seen(obj)) == plain


def test_a_mirror_object_turned_and_moved():
    obj, control = halves.half(live=False, shift=(0.5, 0.0, 0.0))
    empty = meshes.new_object("Plane")
    obj.modifiers["Mirror"].mirror_object = empty
    obj.rotation_euler, obj.location, obj.scale = (0.3, 0.4, 0.5), (2.0, 1.0, 0.0), (2.0, 2.0, 2.0)
    update()
    empty.matrix_world = obj.matrix_world.copy()
    empty.location = obj.matrix_world @ control.location.__class__((0.5, 0.0, 0.0))
    update()
    meshes.activate(obj)
    plain = len(meshes.seen(obj))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    move(control, (0.2, 0.5, 0.3))
    steps.solve()
    edge = np.abs(rest(obj)[:, 0] - 0.5) < 1e-6
    assert edge.sum() > 10
    assert np.abs(shown(obj)[edge, 0] - 0.5).max() < 3e-6  # its place is known to single precision in the world
    assert np.abs(shown(obj)[edge, 1:] - rest(obj)[edge, 1:]).max() > 0.1
    assert len(meshes.seen(obj)) == plain


def test_switched_off_while_live_and_on_again():
    obj, control = halves.half()
    turn(control, 0.6)
    move(control, (0.1, 0.3, 0.2))
    mirror = obj.modifiers["Mirror"]
    with_it = shown(obj)
    mirror.show_viewport = False
    update()
    move(control, (0.0, 0.0, 1e-3))
    assert opening(obj) > 1e-3
    mirror.show_viewport = True
    update()
    move(control, (0.0, 0.0, -1e-3))
    assert opening(obj) < CLOSED
    assert np.abs(shown(obj) - with_it).max() < 5e-3 * halves.size(obj)
    obj.modifiers.remove(mirror)
    update()
    move(control, (0.0, 0.0, 1e-3))
    assert opening(obj) > 1e-3


def test_a_binding_knows_its_mirror():
    obj, control = halves.half(live=False)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    move(control, (0.0, 0.3, 0.0))
    steps.solve()
    before = steps.key_positions(obj, "Mean-Value")
    obj.modifiers["Mirror"].use_axis = (False, True, False)
    assert steps.is_bound(obj)
    steps.solve()
    assert np.abs(steps.key_positions(obj, "Mean-Value") - before).max() > 1e-3
    assert obj.meanvalue.bound.vertex_count == len(obj.data.vertices)


@pytest.mark.parametrize(
    "change, text",
    [
        (lambda obj, mirror: setattr(mirror, "show_viewport", False), "off in the viewport"),
        (lambda obj, mirror: put_first(obj, obj.modifiers.new("Bend", 'SIMPLE_DEFORM')), "'Bend' comes before it"),
        (lambda obj, mirror: setattr(mirror, "use_bisect_axis", (True, False, False)), "cuts the mesh"),
        (lambda obj, mirror: turned_mirror(obj, mirror), "askew"),
    ],
)
def test_what_is_not_handled_is_told_by_name(part, change, text):
    obj, _control = halves.half(live=False)
    notes = part("scene.mirrors").notes
    assert notes(obj) == []
    change(obj, obj.modifiers["Mirror"])
    update()
    (note,) = notes(obj)
    assert text in note and "'Mirror'" in note
    meshes.activate(obj)
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}  # the half alone


def put_first(obj, modifier):
    meshes.activate(obj)
    bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def turned_mirror(obj, mirror):
    empty = meshes.new_object("Plane")
    empty.rotation_euler = (0.0, 0.0, 0.5)
    obj.scale = (1.0, 3.0, 1.0)
    mirror.mirror_object = empty


def test_weights_and_merging_modifiers_above_are_no_matter():
    obj, control = halves.half(live=False)
    obj.modifiers.new("Subdivision", 'SUBSURF')
    put_first(obj, obj.modifiers.new("Weights", 'VERTEX_WEIGHT_EDIT'))
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    turn(control, 0.5)
    steps.solve()
    assert opening(obj) < CLOSED


def test_what_deforms_the_mirrored_mesh():
    """A lattice, rig or bend below the Mirror: the half is posed where it is seen, the seam stays in its plane."""
    obj, control = halves.half(live=False)
    bend = obj.modifiers.new("Bend", 'SIMPLE_DEFORM')
    bend.deform_method, bend.deform_axis, bend.angle = 'BEND', 'X', 0.6
    update()
    plain = len(meshes.seen(obj))
    steps.run(obj, "bind")
    move(control, (0.1, 0.3, 0.2))
    meshes.activate(obj)
    steps.solve()
    assert opening(obj) < CLOSED
    assert np.abs(shown(obj) - rest(obj)).max() > 0.2
    assert len(meshes.seen(obj)) == plain


@pytest.mark.parametrize("make", ["beside the plane", "through the plane"])
def test_what_has_no_seam_is_posed_as_ever(make):
    obj, control = halves.half(live=False, shift=(0.5, 0.0, 0.0)) if make[0] == "b" else halves.whole(live=False)
    shapes = []
    for is_mirrored in (True, False):
        obj.modifiers.clear()
        if is_mirrored:
            halves.add_mirror(obj)
        steps.run(obj, "bind")
        control.location.x += 0.3 if is_mirrored else 0.0
        update()
        steps.solve()
        shapes.append(shown(obj))
    assert np.array_equal(*shapes)


def animate(control):
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, 6
    for frame in range(1, 7):
        control.rotation_mode = 'XYZ'
        control.rotation_euler = (0.12 * (frame - 1), 0.05 * frame, 0.0)
        control.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.scene.frame_set(1)


def test_baked_to_a_point_cache(tmp_path):
    obj, control = halves.half(live=False)
    animate(control)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "half.blend"))
    steps.run(obj, "bake")
    shapes = rows(pathlib.Path(tmp_path, "meanvalue_cache", "half", "Half.pc2"))
    assert shapes.shape == (6, len(obj.data.vertices), 3)
    assert max(opening(obj, shape=shape) for shape in shapes) < CLOSED
    assert np.ptp(shapes, axis=0).max() > 0.2
    bpy.context.scene.frame_set(6)
    seen = meshes.seen(obj)
    assert len(seen) == 2 * len(obj.data.vertices) - len(halves.seam(obj))
    # Baked again, above the modifier that plays: still the mirrored mesh.
    assert bpy.ops.meanvalue.bake() == {'FINISHED'}
    assert np.array_equal(rows(pathlib.Path(tmp_path, "meanvalue_cache", "half", "Half.pc2")), shapes)


def own_shape(obj):
    """n x 3: the mesh's own vertices, of what is to be seen with the modifier."""
    bpy.context.view_layer.update()
    return meshes.seen(obj)[: len(obj.data.vertices)].astype(float)


def test_a_mix_keeps_the_seam_closed():
    obj, _control = halves.half(live=False)
    plain, shape = len(meshes.seen(obj)), own_shape(obj) * (1.0, 0.6, 1.0)
    shape[:, 0] *= 1.0 + 0.2 * shape[:, 2]
    seam = shape[:, 0] == 0.0
    key = steps.add_key(obj, "Wider", shape)
    obj.meanvalue.mix.is_on = True
    for value in (0.25, 0.5, 0.75, 1.0):
        key.value = value
        assert np.abs(own_shape(obj)[seam, 0]).max() < CLOSED and len(meshes.seen(obj)) == plain, value
    np.testing.assert_allclose(own_shape(obj), shape, atol=1e-5)


@pytest.mark.parametrize("picked", [0, 5])
def test_a_wrapped_half_keeps_the_seam_closed(picked):
    """Pairs of one side count for both."""
    stretch = np.array((1.2, 0.8, 1.1))
    other, _control = halves.whole(live=False, name="Other")
    other.data.vertices.foreach_set("co", (own_shape(other) * stretch).astype(np.float32).ravel())
    other.data.update()
    obj, _control = halves.half(live=False)
    obj.meanvalue.wrap.target = other
    right = own_shape(obj)
    for vertex in np.append(right.argmax(axis=0), right[:, 1:].argmin(axis=0))[:picked]:
        bpy.ops.meanvalue.pick_wrap_pairs(vertex=int(vertex), place=tuple(right[vertex] * stretch))
    assert bpy.ops.meanvalue.wrap() == {'FINISHED'}
    wrapped = own_shape(obj)
    assert np.abs(wrapped[right[:, 0] == 0.0, 0]).max() < CLOSED
    assert np.abs(wrapped - right * stretch).mean() < 0.015 * np.linalg.norm(np.ptp(right, axis=0))
