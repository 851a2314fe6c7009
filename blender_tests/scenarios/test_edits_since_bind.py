# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that was edited after it was bound."""

import bmesh
import bpy
import numpy as np
import pytest
from support import handles, meshes, steps
from support.handles import update


@pytest.fixture
def grid():
    return steps.posed_grid(meshes.grid())


def add_vertex(bm):
    bm.verts.new((9.0, 9.0, 9.0))


def delete_last_face(bm):
    bm.faces.ensure_lookup_table()
    bmesh.ops.delete(bm, geom=[bm.faces[-1]], context='FACES_ONLY')


def split_face(bm):
    bm.faces.ensure_lookup_table()
    face = bm.faces[5]
    bmesh.utils.face_split(face, face.verts[0], face.verts[2])


def flip_face(bm):
    bm.faces.ensure_lookup_table()
    bm.faces[5].normal_flip()


def reverse_vertices(bm):
    """The same counts, but the anchors' indices now mean other places."""
    for vertex in bm.verts:
        vertex.index = 24 - vertex.index
    bm.verts.sort()


@pytest.mark.parametrize("edit", [add_vertex, delete_last_face, split_face, flip_face, reverse_vertices])
def test_changed_mesh_asks_for_update(grid, status, edit):
    steps.solve()
    steps.edit_mesh(grid, edit)
    with steps.refused("Update", unchanged=grid):
        bpy.ops.meanvalue.solve_from_key()
    assert steps.is_stale(grid)


def test_an_edited_rest_shape_asks_for_update_until_it_is_put_back(grid):
    point = grid.data.shape_keys.key_blocks["Basis"].data[7]
    kept = point.co.copy()
    point.co.z += 0.25
    grid.data.update_tag()
    bpy.context.view_layer.update()
    with steps.refused("rest shape", "Update", unchanged=grid):
        bpy.ops.meanvalue.solve_from_key()
    assert steps.is_stale(grid)
    point.co = kept
    grid.data.update_tag()
    bpy.context.view_layer.update()
    assert steps.is_bound(grid)
    steps.solve()


def test_moved_vertices_of_a_mesh_without_keys_are_an_edited_rest_shape():
    obj = steps.bound_grid(meshes.grid())
    obj.data.vertices[7].co.z += 0.25
    steps.add_pose_key(obj)
    with steps.refused("rest shape"):
        bpy.ops.meanvalue.solve_from_key()


def test_changed_anchors_bind_again_by_themselves(grid):
    grid.vertex_groups["Tip"].add([22], 1.0, 'REPLACE')
    bpy.context.view_layer.update()
    assert steps.is_bound(grid)
    steps.solve()
    assert steps.summary(grid).anchor_count == 5
    assert steps.is_bound(grid)
    rest, result = steps.key_positions(grid, "Basis"), steps.key_positions(grid, "Mean-Value")
    assert np.array_equal(rest[22], result[22])


def test_changed_region_binds_again_by_itself(grid):
    steps.add_group(grid, "Arm", [17, 18, 19, 22, 23, 24])
    grid.meanvalue.roi_group = "Arm"
    steps.solve()
    rest, result = steps.key_positions(grid, "Basis"), steps.key_positions(grid, "Mean-Value")
    fixed = [index for index in range(25) if index not in (17, 18, 19, 22, 23, 24)]
    assert np.array_equal(rest[fixed], result[fixed])


def test_limbs_of_a_stiffness_keep_their_lengths_and_what_is_painted_binds_again():
    obj, control = handles.tube(live=False)
    rings = np.arange(handles.RINGS * handles.SEGMENTS).reshape(handles.RINGS, -1)
    handles.move(control, (4.0, 0.0, -3.0))
    group, limbs = obj.vertex_groups.new(name="Limbs"), rings[[*range(6), *range(11, 17)]].ravel().tolist()
    strains = []
    for name, weight in (("", 1.0), ("Limbs", 0.0), ("Limbs", 1.0)):
        obj.meanvalue.stiffness_group = name
        group.add(limbs, weight, 'REPLACE')
        handles.update()
        steps.solve()
        shapes = handles.rest(obj), handles.shown(obj)
        rest, shown = (np.linalg.norm(each[rings[5]].mean(0) - each[rings[1]].mean(0)) for each in shapes)
        strains.append(abs(shown / rest - 1.0))
    assert strains[1] == strains[0]
    assert strains[2] < 0.6 * strains[0]


def test_another_group_with_the_same_vertices_is_no_change(grid):
    steps.add_group(grid, "Also the tip", [24])
    grid.meanvalue.handles[1].name = "Also the tip"
    assert steps.is_bound(grid)


def test_posing_and_renaming_are_no_edits(grid):
    steps.move(grid, [24, 12], (1.0, 2.0, 3.0))
    grid.name = "Renamed"
    grid.data.name = "Renamed Too"
    grid.meanvalue.result_key = "Other"
    bpy.context.view_layer.update()
    assert steps.is_bound(grid)
    steps.solve()
    assert "Other" in grid.data.shape_keys.key_blocks


def grabbed_ear():
    """(object, its control, vertices of the handle): a monkey whose ear was pulled."""
    bpy.ops.mesh.primitive_monkey_add()
    obj = bpy.context.object
    ear = max(obj.data.vertices, key=lambda vertex: vertex.co.x).index
    assert bpy.ops.meanvalue.grab(vertex=ear, offset=(0.3, 0.0, 0.4), size=0.3) == {'FINISHED'}
    bpy.context.view_layer.update()
    meshes.activate(obj)
    handle = obj.meanvalue.handles[0]
    return obj, handle.control, steps.held(obj, handle.name)


def in_world(obj, vertices):
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    return np.array([tuple(obj.matrix_world @ mesh.vertices[vertex].co) for vertex in vertices])


@pytest.mark.parametrize("change", ["nothing", "scale", "origin"])
@pytest.mark.parametrize("is_subdivided", [False, True])
def test_what_is_posed_stays_at_its_control_when_what_it_is_of_changes(change, is_subdivided):
    obj, control, ear = grabbed_ear()
    if change == "scale":
        obj.scale = (2.0, 2.0, 2.0)
        bpy.context.view_layer.update()
    before, size = in_world(obj, ear), max(obj.dimensions)
    if change == "scale":
        bpy.ops.object.transform_apply(location=False, rotation=False, scale=True)
    elif change == "origin":
        bpy.context.scene.cursor.location = (1.0, 2.0, 3.0)
        bpy.ops.object.origin_set(type='ORIGIN_CURSOR')
    if is_subdivided:
        steps.in_edit_mode(bpy.ops.mesh.subdivide)()
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    obj.update_tag()
    assert np.abs(in_world(obj, ear) - before).max() < 1e-3 * size
    control.location.x += 0.1 * size / obj.scale[0]
    moved = in_world(obj, ear) - before
    assert np.abs(moved - (0.1 * size, 0.0, 0.0)).max() < 2e-3 * size


# -- what the panel says of an object, after edits as after settings ---------------------------------------------------


@pytest.fixture
def problem(part):
    return part("posing.bridge.scene_input").fit_problem


def test_in_edit_mode(problem):
    obj = steps.bound_grid(meshes.grid())
    update()
    assert problem(obj) is None
    bpy.ops.object.mode_set(mode='EDIT')
    obj.data.update_tag()
    update()
    assert steps.is_bound(obj)


def test_a_new_file_is_not_mistaken_for_the_old_one(problem, tmp_path):
    obj = steps.bound_grid(meshes.grid())
    update()
    problem(obj)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "bound.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    obj = meshes.grid()
    assert problem(obj)[1] is False
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "bound.blend"))
    assert steps.is_bound(bpy.data.objects["Grid"])
