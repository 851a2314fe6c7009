# SPDX-License-Identifier: GPL-3.0-or-later
"""Kept poses show again what they showed, after something else changed."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Matrix
from support import handles, meshes, rigs, steps
from test_mirror_keys import winged


def weights(obj, _rig):
    for vertex in obj.data.vertices:
        obj.vertex_groups["Wing.L"].add([vertex.index], min(1.0, max(0.0, 0.5 + 0.2 * vertex.co.z)), 'REPLACE')


def roll(obj, rig):
    meshes.activate(rig)
    bpy.ops.object.mode_set(mode='EDIT')
    rig.data.edit_bones["Wing.L"].roll += math.radians(20.0)
    bpy.ops.object.mode_set(mode='OBJECT')
    meshes.activate(obj)


def constrain(_obj, rig):
    limit = rig.pose.bones["Wing.L"].constraints.new('LIMIT_ROTATION')
    limit.use_limit_x, limit.max_x, limit.owner_space = True, math.radians(40.0), 'LOCAL'


def dual(obj, _rig):
    obj.modifiers[0].use_deform_preserve_volume = True


def basis(obj, _rig):
    obj.active_shape_key_index = 0
    steps.edit_mesh(obj, lambda bm: [setattr(vertex.co, "x", vertex.co.x + 0.3) for vertex in bm.verts])  # keys too
    obj.active_shape_key_index = 1


@pytest.mark.parametrize("change", [weights, roll, constrain, dual, basis])
def test_after_a_change_keys_show_what_was_seen(change):
    obj, rig = winged()
    rigs.bend(rig, -70.0, "Wing.L")
    steps.add_key(obj, "Down.L", steps.key_positions(obj, "Up.L"))
    obj.active_shape_key_index = 2
    bpy.ops.meanvalue.drive_by_bone()
    wanted = {}
    for degrees in (60.0, -70.0):
        rigs.bend(rig, degrees, "Wing.L")
        wanted[degrees] = rigs.seen(obj)
    obj.data.shape_keys.key_blocks["Up.L"].driver_remove("value")  # whose constraint would not let it be at 1
    rigs.bend(rig, 12.0, "Wing.L")
    change(obj, rig)
    handles.update()
    pose, found = rig.pose.bones["Wing.L"].rotation_euler.copy(), []
    for does in ('CHECK', 'REFRESH_ALL'):
        assert bpy.ops.meanvalue.drive_by_bone(does=does) == {'FINISHED'}
        off = 0.0
        for degrees, values in ((60.0, (1.0, 0.0)), (-70.0, (0.0, 1.0))):
            rigs.bend(rig, degrees, "Wing.L")
            for key, value in zip(obj.data.shape_keys.key_blocks[1:], values, strict=True):
                key.driver_remove("value")
                key.value = value
            off = max(off, np.abs(rigs.seen(obj) - wanted[degrees]).max() / rigs.size(obj))
        rigs.bend(rig, 12.0, "Wing.L")
        found.append(off)
    assert found[0] > 1e-3 and found[1] < 1e-5
    assert rig.pose.bones["Wing.L"].rotation_euler == pose


def with_sleeve(part):
    """As winged(), in a sleeve on the same bones whose key goes by that of the mesh, kept at the pose."""
    obj, rig = winged()
    sleeve = obj.copy()
    sleeve.name, sleeve.data = "Sleeve", obj.data.copy()
    obj.users_collection[0].objects.link(sleeve)
    sleeve.data.transform(Matrix.Diagonal((1.3, 1.3, 1.0, 1.0)), shape_keys=True)
    worn, key = (each.data.shape_keys.key_blocks["Up.L"] for each in (sleeve, obj))
    worn.driver_remove("value")
    part("scene.along").drive(worn, key)
    bpy.ops.meanvalue.find_along()
    obj.meanvalue.along[0].is_taken = True
    assert bpy.ops.meanvalue.drive_by_bone(now=True) == {'FINISHED'}
    return obj, sleeve, rig


def test_one_key_is_refreshed_with_what_goes_along_and_the_list_tells_how_far_off_it_is(part, capfd):
    obj, sleeve, rig = with_sleeve(part)
    wanted, key = rigs.seen(sleeve), obj.data.shape_keys.key_blocks["Up.L"]
    weights(sleeve, rig)
    for does, low, high in (('CHECK', 1e-3, 1.0), ('REFRESH', 0.0, 1e-5), ('CHECK', 0.0, 1e-5)):
        assert bpy.ops.meanvalue.drive_by_bone(does=does) == {'FINISHED'}
        handles.update()
        off = np.abs(rigs.seen(sleeve) - wanted).max() / rigs.size(sleeve)
        assert low <= off <= high
        assert part("posing.bridge.key_poses").off_by(key) == pytest.approx(off, rel=0.1, abs=1e-5)
    key.data[3].co.x += 0.1  # an artist's
    edited = steps.key_positions(obj, "Up.L")
    assert bpy.ops.meanvalue.drive_by_bone(does='REFRESH_ALL') == {'FINISHED'}
    assert np.array_equal(steps.key_positions(obj, "Up.L"), edited)
    assert "Edited since, and left as they are: 'Up.L'" in capfd.readouterr().out


def test_a_pair_keeps_the_artists_driver_and_what_it_loses_is_told(part, capfd):
    obj, sleeve, _rig = with_sleeve(part)
    for each in (obj, sleeve):
        steps.add_key(each, "Up.R", handles.rest(each))
    pair, worn = (each.data.shape_keys.key_blocks["Up.R"] for each in (obj, sleeve))
    pair.slider_min, pair.vertex_group, worn.driver_add("value").driver.expression = -0.5, "Wing.R", "0.25"
    assert bpy.ops.meanvalue.drive_by_bone(does='MIRROR', key="Up.L") == {'FINISHED'}
    assert part("scene.actions").driver_of(worn).driver.expression == "0.25"
    told = capfd.readouterr().out
    assert "Range Min of 'Up.R' was -0.5" in told and "own are not mirrored: 'Up.R'" in told
