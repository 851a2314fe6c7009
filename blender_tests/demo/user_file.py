# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's own mesh: from a file to a Subject."""

import math

import bpy
import numpy as np
from mathutils import Matrix
from mathutils.kdtree import KDTree

from . import DemoError, photograph, pose, scene_mesh
from .arguments import UP_AXES
from .off_file import read_off
from .subject import Subject, View, bent_chord

#: How much of the figure, from below, are feet; of the size how far its surroundings
#: follow, and where it bends; how it is lifted.
FEET, LIMB, BEND, LIFT_DEG, ASIDE_DEG = 0.2, 0.3, 0.22, 55.0, 70.0
#: Of the size: what is no farther from what moves would go along.
NEAR = 0.02
CLAY_COLOUR = (0.58, 0.54, 0.48)

# Operators by format, the newer name first: Blender replaced its Python importers one by one.
GLTF = (".glb", ".gltf", ".vrm")  # VRM is glTF by another name
IMPORTERS = {
    **dict.fromkeys(GLTF, (("import_scene", "gltf"),)),
    ".obj": (("wm", "obj_import"), ("import_scene", "obj")),
    ".ply": (("wm", "ply_import"), ("import_mesh", "ply")),
    ".stl": (("wm", "stl_import"), ("import_mesh", "stl")),
}


def user_subject(options):
    """Loads options.file and makes what is to be posed of it. @throws DemoError."""
    obj = load(options)
    prepare(obj, options.up)
    title = f"{options.file.name}, what reaches out farthest is lifted"
    view, grab = farthest_lifted(obj)
    return Subject(title, options.file.stem, obj, view=view, grab=grab, companions=companions(obj))


def farthest_lifted(obj):
    """The view and the `grab` of a Subject: what is farthest from the middle of the figure to one side, but for its
    feet, is lifted, seen from aside, rather from the front."""
    seen = pose.seen_in_world(obj)[: len(obj.data.vertices)]
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = np.linalg.norm(high - low)
    out = (seen - 0.5 * (low + high)) * (1.0, 1.0, 0.0)
    far = np.linalg.norm(out, axis=1) + 1e-3 * out[:, 0]  # of two sides that are alike the left one
    vertex = int(np.where(seen[:, 2] > low[2] + FEET * (high[2] - low[2]), far, 0.0).argmax())
    points, place = np.unique(seen.round(6), axis=0, return_inverse=True)  # seams of the texture are joined
    place = place.reshape(-1)
    away = np.linalg.norm(points - seen[vertex], axis=1)
    limb = np.flatnonzero(scene_mesh.connected_part(away <= BEND * size, place[vertex], place[scene_mesh.edges(obj)]))
    root = points[limb[away[limb] >= 0.9 * away[limb].max()]].mean(axis=0)
    axis = np.cross(seen[vertex] - root, (0.0, 0.0, 1.0))
    target = bent_chord(seen[vertex], root, axis / np.linalg.norm(axis), np.radians(LIFT_DEG))
    outwards = np.degrees(np.arctan2(out[vertex, 0], -out[vertex, 1]))
    view = View(azimuth_deg=min((outwards - ASIDE_DEG, outwards + ASIDE_DEG), key=abs))
    return view, (vertex, tuple(target - seen[vertex]), LIMB)


def rig_of(obj):
    return next((each.object for each in obj.modifiers if each.type == 'ARMATURE' and each.object), None)


def companions(obj):
    """The other mesh objects on the rig of `obj`: its clothes, hair and eyes."""
    rig = rig_of(obj)
    others = (other for other in bpy.context.scene.objects if other.type == 'MESH' and other != obj)
    return tuple(other for other in others if rig is not None and rig_of(other) == rig)


def hide_what_would_stay_behind(subject):
    """Companions that are near to what the pose moves and do not go along leave the picture."""
    before, after = (photograph.posed_points(subject.obj, value) for value in (0.0, 1.0))
    size = np.linalg.norm(np.ptp(before, axis=0))
    moved = before[np.linalg.norm(after - before, axis=1) > NEAR * size]
    tree = KDTree(len(moved))
    for index, point in enumerate(moved):
        tree.insert(point, index)
    tree.balance()
    for other in subject.companions:
        keys = other.data.shape_keys
        if keys is not None and other.meanvalue.result_key in keys.key_blocks:
            continue  # goes along
        near = (tree.find(point)[2] for point in pose.seen_in_world(other))
        other.hide_render = other.hide_viewport = any(each is not None and each < NEAR * size for each in near)
        if other.hide_render:
            print(f"'{other.name}' is left out: the pose of '{subject.obj.name}' would leave it behind")


def load(options):
    """The mesh object that options.file and options.object mean."""
    suffix = options.file.suffix.lower()
    if suffix == ".blend":
        try:
            bpy.ops.wm.open_mainfile(filepath=str(options.file.resolve()), load_ui=False)
        except RuntimeError as error:
            raise DemoError(f"{options.file} cannot be opened: {pose.operator_message(error)}") from error
    elif suffix == ".off":
        vertices, polygons = read_off(options.file)
        obj = scene_mesh.new_object(options.file.stem, vertices, polygons)
        if obj.data.validate():
            print(f"{options.file}: faces that Blender cannot use were left out")
        bpy.context.view_layer.objects.active = obj
    else:
        import_mesh(options.file, suffix)
    return choose_object(options)


def import_mesh(path, suffix):
    """Imports by whichever operator this Blender has."""
    if suffix in GLTF and "bool" not in vars(np):
        np.bool = bool  # Blender 3.4's importer asks for it; the numpy of Debian 12 no longer has it
    for module, name in IMPORTERS[suffix]:
        if name not in dir(getattr(bpy.ops, module)):
            continue
        try:
            getattr(getattr(bpy.ops, module), name)(filepath=str(path.resolve()))
        except RuntimeError as error:
            raise DemoError(f"{path} cannot be imported: {pose.operator_message(error)}") from error
        return
    raise DemoError(f"this Blender has no importer for {suffix}; convert {path} to .off or .obj")


def choose_object(options):
    """The named, else the active, else the only mesh object of the view layer; of a glTF the largest, first of those
    on a rig."""
    meshes = {obj.name: obj for obj in bpy.context.view_layer.objects if obj.type == "MESH"}
    names = ", ".join(f"'{name}'" for name in meshes) or "none"
    if options.object is not None:
        if options.object not in meshes:
            raise DemoError(f"{options.file} has no mesh object '{options.object}'; its mesh objects: {names}")
        return meshes[options.object]
    active = bpy.context.view_layer.objects.active
    if active is not None and active.name in meshes and (options.file.suffix.lower() == ".blend" or len(meshes) == 1):
        return active
    if len(meshes) == 1:
        return next(iter(meshes.values()))
    if meshes and options.file.suffix.lower() in GLTF:
        return max(meshes.values(), key=lambda obj: (rig_of(obj) is not None, np.linalg.norm(obj.dimensions)))
    if not meshes:
        raise DemoError(f"{options.file} has no mesh, or is not a {options.file.suffix} file; see the messages above")
    raise DemoError(f"{options.file} has {len(meshes)} mesh objects; choose one with --object NAME out of: {names}")


def prepare(obj, up):
    """Makes the object the only one in the picture, in Object Mode, upright, shaded and with a material."""
    if obj.mode != "OBJECT":
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="OBJECT")
    together = companions(obj)
    for other in bpy.context.scene.objects:
        other.hide_render = other != obj and other not in together
    obj.show_only_shape_key = False  # a pinned key would hide the result
    bpy.context.scene.render.use_compositing = bpy.context.scene.render.use_sequencer = False
    if up is not None:
        axis, angle_deg = UP_AXES[up]
        obj.matrix_world = Matrix.Rotation(math.radians(angle_deg), 4, axis)
    if not any(slot.material for slot in obj.material_slots):
        obj.data.materials.clear()
        obj.data.materials.append(scene_mesh.plain_material("Clay", CLAY_COLOUR, 0.5))
        scene_mesh.shade_smooth(obj)
