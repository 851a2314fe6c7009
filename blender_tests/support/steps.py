# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does, step by step."""

import contextlib
import types

import bpy
import numpy as np
import pytest

from . import installed
from .meshes import activate
from .snapshot import assert_same, snapshot


def add_group(obj, name, indices, weight=1.0):
    group = obj.vertex_groups.new(name=name)
    group.add([int(index) for index in indices], weight, 'REPLACE')
    return group


def members(obj, name):
    """Ascending indices of the vertices of weight above 0 in a vertex group."""
    group = obj.vertex_groups[name].index
    return [
        vertex.index
        for vertex in obj.data.vertices
        if any(element.group == group and element.weight > 0.0 for element in vertex.groups)
    ]


def add_weights(obj, name, weights):
    """A vertex group of the vertices with a weight above 0, of one for each vertex."""
    group = obj.vertex_groups.new(name=name)
    for index, weight in enumerate(weights):
        if weight > 0.0:
            group.add([index], float(weight), 'REPLACE')


def add_handle(obj, name, indices, **options):
    """A vertex group and its handle, by the operator. Returns the control, which is active then; None for a pin."""
    add_group(obj, name, indices)
    assert bpy.ops.meanvalue.add_handle(group=name, **options) == {'FINISHED'}
    return obj.meanvalue.handles[name].control


def select_in_edit_mode(obj, indices):
    activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='DESELECT')
    bpy.ops.object.mode_set(mode='OBJECT')
    for index in indices:
        obj.data.vertices[index].select = True
    bpy.ops.object.mode_set(mode='EDIT')


def in_edit_mode(operator, **options):
    """A function that runs an operator on all vertices of the active object, in Edit Mode."""

    def edit(_obj=None):
        bpy.ops.object.mode_set(mode='EDIT')
        bpy.ops.mesh.select_all(action='SELECT')
        operator(**options)
        bpy.ops.object.mode_set(mode='OBJECT')

    return edit


def held(obj, name):
    """Ascending indices of the vertices that the handle `name` has."""
    return installed.part("posing.bridge.members").of(obj, [obj.meanvalue.handles[name]])[0].tolist()


def list_anchors(obj, **groups):
    """list_anchors(obj, Hand=[1, 2]) makes the vertex groups and pins them, by the operator."""
    for name, indices in groups.items():
        add_group(obj, name, indices or [0])
        assert bpy.ops.meanvalue.add_handle(pin=True, group=name) == {'FINISHED'}
        if not indices:
            obj.vertex_groups[name].remove([0])


def add_key(obj, name, shape, relative="Basis"):
    """A shape key, n x 3, with the Basis if that is missing. It is at 0: from Blender 5.2 on a new one is at 1."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)
    key = obj.shape_key_add(name=name, from_mix=False)
    key.relative_key = obj.data.shape_keys.key_blocks[relative]
    key.data.foreach_set("co", np.asarray(shape, np.float32).ravel())
    key.value = 0.0
    return key


def add_pose_key(obj):
    """A shape key in the rest shape, active and shown, to move vertices in."""
    keys = obj.data.shape_keys
    rest = keys.reference_key.data if keys else obj.data.vertices
    key = add_key(obj, "Pose", [tuple(each.co) for each in rest], keys.reference_key.name if keys else "Basis")
    key.value = 1.0
    obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(key.name)
    return key


def move(obj, indices, offset, key=None):
    """Moves vertices of a shape key (the active one), as an artist would do in Edit Mode."""
    key = key or obj.active_shape_key
    for index in indices:
        key.data[index].co = [a + b for a, b in zip(key.data[index].co, offset, strict=True)]
    obj.data.update_tag()


def bound_grid(obj):
    """Anchors at three corners of a 5 x 5 grid, bound."""
    list_anchors(obj, Corners=[0, 4, 20], Tip=[24])
    assert bpy.ops.meanvalue.bind() == {'FINISHED'}
    return obj


def is_bound(obj):
    """As the panel has it: bound, and nothing is in the way."""
    return obj.meanvalue.bound.is_bound and installed.part("posing.bridge.scene_input").fit_problem(obj) is None


def summary(obj):
    """Counts of what `obj` is bound as."""
    bind_input = installed.part("posing.bridge.scene_input").gather(obj)
    report = installed.part("solver.session").cache.get(bind_input.fingerprint).deformer.report
    return types.SimpleNamespace(
        anchor_count=len(bind_input.anchors),
        free_count=np.count_nonzero(bind_input.free),
        following_part_count=sum(carrier >= 0 for carrier in report.carriers),
    )


def is_stale(obj):
    """Whether the panel asks for Update."""
    found = installed.part("posing.bridge.scene_input").fit_problem(obj)
    return found is not None and found[1] and "Update" in found[0]


def posed_grid(obj, offset=(0.0, 0.5, 1.0)):
    """bound_grid with a pose key in which the tip was moved."""
    bound_grid(obj)
    add_pose_key(obj)
    move(obj, [24], offset)
    return obj


def solve():
    """As the mesh is posed: by its controls, or by the active shape key where it has none."""
    handles = bpy.context.object.meanvalue.handles
    has_controls = any(handle.follows == 'CONTROL' for handle in handles) or bpy.context.object.type != 'MESH'
    operator = bpy.ops.meanvalue.solve if has_controls else bpy.ops.meanvalue.solve_from_key
    assert operator() == {'FINISHED'}


def key_positions(obj, name):
    key = obj.data.shape_keys.key_blocks[name]
    return np.array([tuple(point.co) for point in key.data], np.float32)


def edit_mesh(obj, edit):
    """Calls edit(bmesh) in Edit Mode, then goes back to Object Mode."""
    import bmesh

    bpy.ops.object.mode_set(mode='EDIT')
    edit(bmesh.from_edit_mesh(obj.data))
    bmesh.update_edit_mesh(obj.data)
    bpy.ops.object.mode_set(mode='OBJECT')


def scene_to_render(path):
    """The scene, with a camera; tiny pictures of its first three frames are written to `path` and a number."""
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine = 'BLENDER_WORKBENCH'
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.render.filepath = str(path)
    scene.frame_start, scene.frame_end = 1, 3
    return scene


def go_to(frame):
    whole = int(np.floor(frame))
    bpy.context.scene.frame_set(whole, subframe=float(frame - whole))


def run(obj, operator, **options):
    """An operator of ours on `obj`, which is the active one then."""
    activate(obj)
    assert getattr(bpy.ops.meanvalue, operator)(**options) == {'FINISHED'}


@contextlib.contextmanager
def refused(*texts, unchanged=None):
    """The operator called inside reports an error that has all `texts`, and leaves an object as it was."""
    before = snapshot(unchanged) if unchanged else None
    with pytest.raises(RuntimeError) as caught:
        yield
    message = str(caught.value)
    for text in texts:
        assert text in message, message
    if unchanged:
        assert_same(before, snapshot(unchanged))


def reopened(obj, path):
    """The object of the same name, after the file was saved as `path` and opened again."""
    name = obj.name
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    return bpy.data.objects[name]
