# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's updates say of a mesh: whether it was edited, written to, mixed, or only moved by its rig."""

import contextlib

import bpy
import numpy as np
import pytest
from support import handles, meshes, rigged
from support.handles import update


@pytest.fixture
def changes(part):
    """Context manager: gives a list that has (name, change, whether its modifiers moved it) of what was told inside."""
    told = []

    def meanvalue_test_listener(_scene, depsgraph):
        told.extend((obj.name, change.name, is_rigged) for obj, change, is_rigged in part("live.updates").of(depsgraph))

    @contextlib.contextmanager
    def listening():
        update()
        told.clear()
        yield told
        update()

    lists = (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.frame_change_post)
    for handlers_list in lists:
        handlers_list.append(meanvalue_test_listener)
    yield listening
    for handlers_list in lists:
        handlers_list.remove(meanvalue_test_listener)


@pytest.fixture
def tube():
    return rigged.tube()


def test_a_bone_that_moves(changes, tube):
    obj, rig = tube
    with changes() as told:
        rigged.bend(rig, 20.0)
    assert told == [(obj.name, 'RIG', True)]


def test_the_object_that_moves(changes, tube):
    obj, _rig = tube
    with changes() as told:
        obj.location.x += 1.0
    assert told == [(obj.name, 'RIG', True)]


def test_a_control_that_moves(changes):
    _obj, control = handles.tube(live=False)
    with changes() as told:
        control.location.x += 1.0
    assert told == []


def test_sliders_that_are_driven_or_animated(changes, tube):
    obj, rig = tube
    key = obj.shape_key_add(name="Corrective", from_mix=False)
    driver = key.driver_add("value").driver
    variable = driver.variables.new()
    variable.type = 'TRANSFORMS'
    variable.targets[0].id, variable.targets[0].bone_target = rig, "Upper"
    variable.targets[0].transform_type = 'ROT_X'
    driver.expression = variable.name
    with changes() as told:
        rigged.bend(rig, 20.0)
    assert told == [(obj.name, 'SLIDERS', True)]
    key.driver_remove("value")
    key.value = 0.0
    key.keyframe_insert("value", frame=1)
    key.value = 1.0
    key.keyframe_insert("value", frame=9)
    with changes() as told:
        bpy.context.scene.frame_set(4)
    assert told == [(obj.name, 'SLIDERS', False)]


def test_our_own_writing(changes, tube, part):
    obj, rig = tube
    keys = part("scene.shape_keys")
    key, shape = obj.data.shape_keys.key_blocks["Mean-Value"], keys.result_positions(obj)
    shape[0] += 1.0
    with changes() as told:
        keys.write_positions(obj.data, key, shape)
    assert told == [(obj.name, 'KEYS', False)]
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    obj.modifiers.clear()
    update()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    np.testing.assert_allclose(evaluated.vertices[0].co, shape[0], atol=1e-5)
    obj.modifiers.new("Armature", 'ARMATURE').object = rig
    shape[0] += 1.0
    with changes() as told:
        keys.write_positions(obj.data, key, shape)
        rigged.bend(rig, 30.0)
    assert told == [(obj.name, 'KEYS', True)], "a bone that moves together with it is not missed"


def edit_mode(obj):
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.object.mode_set(mode='OBJECT')


def paint_mode(obj):
    meshes.activate(obj)
    bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
    bpy.ops.object.vertex_group_normalize_all(lock_active=False)
    bpy.ops.object.mode_set(mode='OBJECT')


EDITS = {
    "group": lambda obj: obj.vertex_groups["Top"].remove([handles.TOP[0]]),
    "weight": lambda obj: setattr(obj.data.vertices[0].groups[0], "weight", 0.5),
    "vertex": lambda obj: setattr(obj.data.vertices[0], "co", (0.0, 0.0, 5.0)),
    "point of a key": lambda obj: setattr(obj.data.shape_keys.reference_key.data[0], "co", (0.0, 0.0, 5.0)),
    "mesh": lambda obj: obj.data.update_tag(),
    "object": lambda obj: obj.update_tag(),
    "setting": lambda obj: setattr(obj.meanvalue, "rigidity", 3.0),
    "edit mode": edit_mode,
    "weight paint": paint_mode,
    "modifier": lambda obj: obj.modifiers.new("Smooth", 'SMOOTH'),
}


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS.keys())
def test_edits(changes, tube, edit):
    obj, _rig = tube
    with changes() as told:
        edit(obj)
    assert any(each[:2] == (obj.name, 'MESH') for each in told), told


def test_a_script_that_writes_keys_and_tags_them(changes, tube):
    obj, _rig = tube
    with changes() as told:
        obj.data.shape_keys.reference_key.data.foreach_set("co", np.zeros(3 * len(obj.data.vertices), np.float32))
        obj.data.shape_keys.update_tag()
    assert told == [(obj.name, 'KEYS', False)]
