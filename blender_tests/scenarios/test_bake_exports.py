# SPDX-License-Identifier: GPL-3.0-or-later
"""What is baked, through Blender's own exporters and back."""

import addon_utils
import bpy
import numpy as np
import pytest
from support import meshes
from support.baking import FRAMES, animated_tube, bake, save

#: {kind: (exporter, importer, suffix, options of both)}. Else FBX has that of objects alone, and not all frames.
FBX = {"bake_anim_use_all_actions": False, "bake_anim_use_nla_strips": False, "bake_anim_simplify_factor": 0.0}
AT_ONCE = {"as_background_job": False}
KINDS = {
    "fbx": (bpy.ops.export_scene.fbx, bpy.ops.import_scene.fbx, "fbx", FBX, {"anim_offset": 0.0}),
    "gltf": (bpy.ops.export_scene.gltf, bpy.ops.import_scene.gltf, "glb", {}, {}),
    "alembic": (bpy.ops.wm.alembic_export, bpy.ops.wm.alembic_import, "abc", {"end": FRAMES, **AT_ONCE}, AT_ONCE),
    "usd": (bpy.ops.wm.usd_export, bpy.ops.wm.usd_import, "usdc", {"export_animation": True}, {}),
}
KEYS, BONES = {"target": 'SHAPE_KEYS', "tolerance_share": 0}, {"target": 'ARMATURE', "influences": 8, "root_bone": True}


def in_the_world(obj):
    shapes = []
    for time in (1, 4, 7, FRAMES):
        bpy.context.scene.frame_set(time)
        obj.data.id_data.update_tag()
        world = np.array(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
        shapes.append(meshes.seen(obj) @ world[:3, :3].T + world[:3, 3])
    return np.stack(shapes)


@pytest.mark.parametrize(("kind", "options", "more", "near"), [
    ("fbx", KEYS, {"object_types": {'MESH'}}, 1e-2),  # of 10; it knows nothing of muted keys: they have the value 0
    ("fbx", BONES, {"add_leaf_bones": False}, 1e-4),
    ("gltf", {"target": 'ARMATURE'}, {}, 1e-4),
    ("gltf", BONES, {"export_all_influences": True}, 1e-4),
    *((kind, options, {}, 1e-4) for kind in ("alembic", "usd") for options in (KEYS, {})),
])  # fmt: skip
def test_export_and_import(monkeypatch, tmp_path, kind, options, more, near):
    if not getattr(bpy.app.build_options, kind, True):
        pytest.skip(f"this Blender is built without {kind}")
    addon_utils.enable("io_scene_gltf2" if kind == "gltf" else "io_scene_fbx")
    monkeypatch.setattr(np, "bool", bool, raising=False)  # Blender 3.4's glTF asks numpy for it
    obj, _control = animated_tube()
    obj.data.polygons.foreach_set("use_smooth", [True] * len(obj.data.polygons))  # else glTF has a vertex for each face
    meshes.activate(obj)
    save(tmp_path)
    bake(**options)
    bpy.ops.meanvalue.unbake(keep_bake=True)  # an importer plays one action of several
    before, bones = in_the_world(obj), {bone.name for rig in bpy.data.armatures for bone in rig.bones}
    export, come, suffix, *way = KINDS[kind]
    path = str(tmp_path / f"baked.{suffix}")
    assert export(filepath=path, **way[0], **more) == {'FINISHED'}
    bpy.data.batch_remove([*bpy.data.objects, *bpy.data.armatures])
    assert come(filepath=path, **way[1]) == {'FINISHED'}
    came = next(each for each in bpy.data.objects if each.type == 'MESH' and "Tube" in each.name)
    assert np.ptp(before, axis=0).max() > 1.0 and np.abs(in_the_world(came) - before).max() < near
    assert {bone.name for rig in bpy.data.armatures for bone in rig.bones} == bones
