# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects go along with a mesh that is posed (`along` of its settings), and why others do not."""

import bpy
import numpy as np

from .. import compat
from ..errors import MeanValueError
from ..solver import native_loader
from . import actions, kept, mesh_arrays, pose_object_making, pose_objects, rig_space, shape_keys, subject
from .core import motion
from .core.point_sets import bounding_box_diagonal, require_finite

#: Of what lies on a mesh half is so near to it, as a share of the mesh's size; so many vertices tell.
NEAR, SAMPLES = 0.2, 500

#: Modifiers and parents by which an object follows another by itself.
BY_ITSELF = {'SURFACE_DEFORM', 'MESH_DEFORM', 'BONE', 'VERTEX', 'VERTEX_3'}

_carriers = {}  # {session key of what goes along: that of the mesh}, of all in the file; empty: not known


def listed(obj):
    """[(line of the list, its object)] of those that were not deleted."""
    found = [(line, line.object) for line in obj.meanvalue.along if line.object is not None]
    return [(line, other) for line, other in found if other.visible_get() or other.users_collection]


def taken(obj):
    """[(line, object)] of those that go along."""
    return [(line, other) for line, other in listed(obj) if line.is_taken and problem(obj, other) is None]


def problem(obj, other):
    """Why `other` is left alone, in words, or None. Cheap enough for drawing."""
    name, absolute = f"'{other.name}'", shape_keys.absolute_problem(other)
    found = subject.object_problem(other) or (absolute and f"{name} is left alone. {absolute}")
    key = None if found else shape_keys.result(other)
    source = key and actions.source_of(key)
    if _by_itself(other):
        return f"{name} follows by itself: {_by_itself(other)[0].replace('_', ' ').title()}"
    if found:
        return found
    bound = [getattr(each, "object", getattr(each, "target", None)) for each in obj.modifiers if each.type in BY_ITSELF]
    if pose_objects.shown(other) in bound:
        return f"{name} deforms '{obj.name}', which would be moved twice"
    if other.data.users - other.data.use_fake_user > 1:
        return f"{name} shares its mesh with other objects. Make it a single user (Object > Relations)"
    if motion.is_flat(np.array(other.matrix_world, np.float64)) or not len(other.data.vertices):
        return f"{name} is scaled to nothing, or has no vertices. Give it a size"
    if len(other.meanvalue.handles) or (key and (source is None or source[0] not in {None, obj.data.shape_keys})):
        return f"{name} has handles or a pose of its own. Apply or discard these to have it go along"
    if _carrier_key(other) not in {None, compat.session_key(obj)}:
        return f"{name} goes along with another mesh already. Untick it there"
    return None


def _by_itself(other):
    ways = pose_objects.shown(other).parent_type, *(each.type for each in other.modifiers)
    return [each for each in ways if each in BY_ITSELF]


def carrier(other):
    """The mesh object that takes `other` along, or None."""
    key = _carrier_key(other)
    found = None if key is None else next((each for each in bpy.data.objects if compat.session_key(each) == key), None)
    return found if found is not None and problem(found, other) is None else None


def let_go(other):
    """It is to be posed by handles of its own."""
    found = carrier(other)
    for line in found.meanvalue.along if found is not None else ():
        line.is_taken &= line.object != other


def _carrier_key(other):
    if not _carriers:
        _carriers[None] = None
        lines = [each for obj in bpy.data.objects if obj.type == 'MESH' for each in listed(obj) if each[0].is_taken]
        for line, posed in sorted(lines, key=_is_of_copy):
            _carriers.setdefault(compat.session_key(posed), compat.session_key(line.id_data))
    return _carriers.get(compat.session_key(other))


def _is_of_copy(each):  # of the mesh whose keys pose what is listed
    source = (key := shape_keys.result(each[1])) and actions.source_of(key)
    return bool(source) and source[0] != each[0].id_data.data.shape_keys


def forget():
    _carriers.clear()


def find(obj):
    """Lists children of the mesh, meshes on its armature, and selected ones that lie on it. Returns how many are new.
    What is on the armature and does not lie on the mesh, or is more of the body than that, is not ticked. What is
    another file's gets a pose object."""
    known, children = {line.object for line in obj.meanvalue.along}, {*pose_objects.shown(obj).children_recursive}
    before = len(known)
    for other in list(bpy.context.scene.objects):
        posed = pose_objects.of(other) or other
        if other.type != 'MESH' or pose_objects.shown(other) != other or posed == obj or posed in known:
            continue
        is_near = other in children or (_is_less(other, obj) and _lies_on(obj, other))
        if is_near or _shared_rigs(obj, other):
            if is_near and pose_objects.is_foreign(posed) and not _by_itself(other):
                posed = pose_object_making.make(other)
            line = obj.meanvalue.along.add()
            line.name, line.object, line.is_taken = other.name, posed, bool(is_near)
            known.add(posed)
    forget()
    return len(known) - before


def body_of(other, active):
    """The mesh object whose first handle takes `other` along: `active`, or else the one that is most of the body; None
    where there is none, or other has handles."""
    meshes = [each for each in bpy.context.scene.objects if each.type == 'MESH' and pose_objects.shown(each) == each]
    meshes = [each for each in meshes if _shared_rigs(each, other) or each == other.parent]
    meshes.sort(key=lambda each: _share(each, other))
    wearers = filter(None, (active, *reversed(meshes)))
    return next((each for each in wearers if _will_take(each, other)), None)


def _will_take(obj, other):
    is_first = obj != other and not (subject.problem_to_begin(obj) or obj.meanvalue.handles or obj.meanvalue.along)
    if not is_first or (_by_itself(other) if pose_objects.is_foreign(other) else problem(obj, other)):
        return False
    return _is_less(other, obj) and (other in pose_objects.shown(obj).children_recursive or _lies_on(obj, other))


def _is_less(other, obj):
    """Whether `other` is less of the body: a suit takes no body along."""
    return _share(other, obj) < _share(obj, other)


def _share(obj, other):
    """How many bones of the armatures of both move `obj`; its size in the world."""
    bones = {bone.name for rig in _shared_rigs(obj, other) for bone in rig.data.bones}
    return sum(group.name in bones for group in obj.vertex_groups), obj.dimensions.length


def remove_deleted(obj):
    """Takes those off the list that a pointer alone keeps in the file."""
    there = [other for _, other in listed(obj)]
    for index in reversed(range(len(obj.meanvalue.along))):
        if obj.meanvalue.along[index].object not in there:
            obj.meanvalue.along.remove(index)


def _shared_rigs(obj, other):
    return {*rig_space.armatures(obj)}.intersection(rig_space.armatures(other))


def to_carrier(obj, other):
    """4 x 4 float64: from the space of `other` to that of `obj`. @throws SceneError if one is scaled to nothing."""
    return np.linalg.inv(subject.to_world(obj)) @ subject.to_world(other)


def _surface(obj):
    """(meanvalue.Surface of the rest shape, its size), kept: a first press and its handle ask for it."""
    rest = shape_keys.rest_positions(obj.data)

    def make():
        require_finite(rest, f"rest shape of '{obj.name}'")
        return native_loader.module().Surface(rest, mesh_arrays.triangles(obj.data, rest)), bounding_box_diagonal(rest)

    return kept.of(obj.data, "surface", make, rest)


def _lies_on(obj, other):
    if not (_shared_rigs(obj, other) or other.select_get()):
        return False
    try:
        points = shape_keys.rest_positions(other.data)
        points = motion.apply(to_carrier(obj, other), points[:: 1 + len(points) // SAMPLES])
        surface, size = _surface(obj)
        away = surface.nearest(points)[2]
        return len(away) > 0 and np.median(away) <= NEAR * size
    except MeanValueError:
        return False
