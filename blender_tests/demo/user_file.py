# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's own mesh: from a file to a Subject with its anchor groups, region and targets."""

import math

import bpy
import numpy as np
from mathutils import Matrix
from mathutils.kdtree import KDTree

from . import motion, photograph, pose, scene_mesh, selection
from .arguments import UP_AXES
from .errors import DemoError
from .off_file import read_off
from .subject import Subject, View

ROI_GROUP = "demo region"
#: Without anchors: how much of the figure, from below, are feet; of the size how far its surroundings
#: follow, and where it bends; how it is lifted.
FEET, LIMB, BEND, LIFT_DEG = 0.2, 0.3, 0.22, 55.0
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
    rest = pose.positions(obj)
    view = View() if options.camera is None else View(*options.camera)
    if not options.anchors:
        title = f"{options.file.name}, what reaches out farthest is lifted"
        return Subject(
            title, options.file.stem, obj, view=view, grab=farthest_lifted(obj), companions=companions(obj)
        )
    for anchor in options.anchors:
        make_group(obj, anchor, rest)
    groups = tuple(anchor.name for anchor in options.anchors)
    return Subject(
        title=f"{options.file.name}, {len(groups)} anchor group{'s' if len(groups) > 1 else ''}",
        file_stem=options.file.stem,
        obj=obj,
        handles=groups,
        roi_group=roi_group(obj, options.roi, rest),
        targets=targets(obj, options, rest),
        view=view,
        companions=companions(obj),
    )


def farthest_lifted(obj):
    """The `grab` of a Subject: what is farthest from the middle of the figure to one side, but for its feet."""
    seen = pose.seen_in_world(obj)[: len(obj.data.vertices)]
    low, high = seen.min(axis=0), seen.max(axis=0)
    size = np.linalg.norm(high - low)
    out = (seen - 0.5 * (low + high)) * (1.0, 1.0, 0.0)
    far = np.linalg.norm(out, axis=1) + 1e-3 * out[:, 0]  # of two sides that are alike the left one
    vertex = int(np.where(seen[:, 2] > low[2] + FEET * (high[2] - low[2]), far, 0.0).argmax())
    points, place = np.unique(seen.round(6), axis=0, return_inverse=True)  # seams of the texture are joined
    place = place.reshape(-1)
    away = np.linalg.norm(points - seen[vertex], axis=1)
    limb = selection.connected_part(
        np.flatnonzero(away <= BEND * size), place[vertex], place[scene_mesh.edges(obj)], len(points)
    )
    root = points[limb[away[limb] >= 0.9 * away[limb].max()]].mean(axis=0)
    axis = np.cross(seen[vertex] - root, (0.0, 0.0, 1.0))
    target = motion.bent_chord(seen[vertex], root, axis / np.linalg.norm(axis), np.radians(LIFT_DEG))
    return vertex, tuple(target - seen[vertex]), LIMB


def rig_of(obj):
    return next((each.object for each in obj.modifiers if each.type == 'ARMATURE' and each.object), None)


def companions(obj):
    """The other mesh objects on the rig of `obj`: its clothes, hair and eyes."""
    rig = rig_of(obj)
    others = (other for other in bpy.context.scene.objects if other.type == 'MESH' and other != obj)
    return tuple(other for other in others if rig is not None and rig_of(other) == rig)


def hide_what_would_stay_behind(subject):
    """Companions that are near to what the pose moves, such as a sleeve, leave the picture."""
    before, after = (photograph.posed_points(subject.obj, value) for value in (0.0, 1.0))
    size = np.linalg.norm(np.ptp(before, axis=0))
    moved = before[np.linalg.norm(after - before, axis=1) > NEAR * size]
    tree = KDTree(len(moved))
    for index, point in enumerate(moved):
        tree.insert(point, index)
    tree.balance()
    for other in subject.companions:
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


def make_group(obj, anchor, rest):
    """Makes sure the anchor's vertex group exists and has vertices. @throws DemoError listing the groups there are."""
    if anchor.selection is not None:
        if anchor.name in obj.vertex_groups:
            raise DemoError(f"'{obj.name}' has a vertex group '{anchor.name}' already; give the selection another name")
        scene_mesh.add_vertex_group(obj, anchor.name, selection.select(anchor.selection, rest, scene_mesh.edges(obj)))
        return
    require_group(obj, anchor.name)
    if len(pose.group_indices(obj, anchor.name)) == 0:
        raise DemoError(f"vertex group '{anchor.name}' has no vertices of weight above zero; assign some in Edit Mode")


def require_group(obj, name):
    """@throws DemoError listing the vertex groups there are."""
    if name not in obj.vertex_groups:
        raise DemoError(f"there is no vertex group '{name}'. {group_advice(obj, name)}")


def group_advice(obj, name):
    """A sentence on how to get anchors out of this object."""
    names = ", ".join(f"'{group.name}'" for group in obj.vertex_groups)
    if names:
        return f"'{obj.name}' has the vertex groups {names}: choose one of these"
    return (
        f"'{obj.name}' has no vertex groups: make one by --anchor {name}=SELECTION or --hold {name}=SELECTION, "
        f"where the selection is {selection.SYNTAX}"
    )


def roi_group(obj, roi, rest):
    """Name of the region's vertex group, made if `roi` is a selection; "" for the whole mesh."""
    if roi is None:
        return ""
    if roi not in obj.vertex_groups and selection.is_selection(roi):
        chosen = selection.select(selection.parse_selection(roi), rest, scene_mesh.edges(obj))
        return scene_mesh.add_vertex_group(obj, ROI_GROUP, chosen).name
    require_group(obj, roi)
    return roi


def targets(obj, options, rest):
    """(n, 3) positions of the anchors, or None where the active shape key has them already. @throws DemoError."""
    key = obj.active_shape_key
    keys = obj.data.shape_keys
    is_posed = key is not None and key != keys.reference_key
    start = pose.positions(obj, key) if is_posed else rest
    result = start.copy()
    for step in options.motions:
        members = pose.group_indices(obj, step.group)
        pivot = result[members].mean(axis=0) if step.centre is None else np.array(step.centre)
        result[members] = motion.turned(result[members], step.axis, np.radians(step.angle_deg), pivot) + step.offset
    anchors = pose.anchor_indices(obj, [anchor.name for anchor in options.anchors])
    if np.array_equal(result[anchors], rest[anchors]):
        where = f"the active shape key '{key.name}' has the anchors at rest" if is_posed else "no shape key poses them"
        raise DemoError(
            f"nothing is moved: {where}. Use --move [NAME] X Y Z or --rotate [NAME] AXIS DEGREES [X,Y,Z], "
            "or a .blend whose active shape key has the anchors where they should go"
        )
    return None if is_posed and not options.motions else result
