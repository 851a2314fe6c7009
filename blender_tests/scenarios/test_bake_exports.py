# SPDX-License-Identifier: GPL-3.0-or-later
"""What is baked, through Blender's own exporters and back."""

import addon_utils
import bpy
import numpy as np
import pytest
from support import meshes
from support.baking import FRAMES, animated_tube, bake, save


def in_the_world(obj, times):
    """(f, n, 3) at each of the frames."""
    shapes = []
    for time in times:
        bpy.context.scene.frame_set(time)
        obj.data.id_data.update_tag()
        world = np.array(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
        shapes.append(meshes.seen(obj) @ world[:3, :3].T + world[:3, 3])
    return np.stack(shapes)


def test_shape_keys_by_fbx(tmp_path):
    """FBX knows nothing of muted keys: that of the pose has the value 0. Blender's importer is a frame late."""
    obj, _control = animated_tube()
    meshes.activate(obj)
    bake(target='SHAPE_KEYS', tolerance_share=0)
    times = [1, 4, 7, FRAMES]
    before = in_the_world(obj, times)
    addon_utils.enable("io_scene_fbx")
    path = str(tmp_path / "baked.fbx")
    whole = {"bake_anim_use_all_actions": False, "bake_anim_use_nla_strips": False}  # else actions of objects alone
    assert bpy.ops.export_scene.fbx(filepath=path, object_types={'MESH'}, **whole) == {'FINISHED'}
    bpy.data.objects.remove(obj)
    assert bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0) == {'FINISHED'}
    (came,) = [each for each in bpy.data.objects if each.type == 'MESH']
    assert np.abs(in_the_world(came, times) - before).max() < 1e-2


@pytest.mark.parametrize("target", ['POINT_CACHE', 'SHAPE_KEYS'])
@pytest.mark.parametrize("format_name", ["alembic", "usd"])
def test_export_and_import(tmp_path, format_name, target):
    if not getattr(bpy.app.build_options, format_name):
        pytest.skip(f"this Blender is built without {format_name}")
    obj, _control = animated_tube()
    save(tmp_path)
    bake(target=target, **({"tolerance_share": 0} if target == 'SHAPE_KEYS' else {}))
    times = [1, 4, 7, FRAMES]
    before = in_the_world(obj, times)
    assert np.ptp(before, axis=0).max() > 1.0
    if format_name == "alembic":
        path = str(tmp_path / "baked.abc")
        export = {"start": 1, "end": FRAMES, "selected": True, "as_background_job": False}
        assert bpy.ops.wm.alembic_export(filepath=path, **export) == {'FINISHED'}
        known = set(bpy.data.objects)
        assert bpy.ops.wm.alembic_import(filepath=path, as_background_job=False) == {'FINISHED'}
    else:
        path = str(tmp_path / "baked.usdc")
        assert bpy.ops.wm.usd_export(filepath=path, selected_objects_only=True, export_animation=True) == {'FINISHED'}
        known = set(bpy.data.objects)
        assert bpy.ops.wm.usd_import(filepath=path) == {'FINISHED'}
    (came,) = [each for each in bpy.data.objects if each not in known and each.type == 'MESH']
    assert np.abs(in_the_world(came, times) - before).max() < 1e-4
