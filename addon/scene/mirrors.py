# SPDX-License-Identifier: GPL-3.0-or-later
"""What mirrors an object's mesh: Mirror modifiers, and the switch Symmetric."""

import math
from typing import NamedTuple

import numpy as np

from .. import wording
from ..errors import SceneError
from . import kept, mesh_arrays, rig_space, shape_keys
from .core import motion, point_sets, welding, whole_mesh

#: What lies in the plane to this share of the size is a seam, also where the modifier merges nothing.
IN_PLANE = 1e-5

#: Planes that stand at right angles, to rounding of single precision, as a cosine.
RIGHT_ANGLE = 1e-5

#: Modifiers above a Mirror that leave the vertices where they are. A Mesh Cache stands for the pose below it.
KEEPING = rig_space.HARMLESS | {'MESH_CACHE'}


class Plane(NamedTuple):
    """In object space. row: unit normal and distance; reach: a vertex no farther from it is merged with its image."""

    row: tuple
    reach: float


def signature(obj):
    """The planes of modifiers: quick to compare, and Blender does not tell of all that changes them."""
    return tuple(_read(obj)[0])


def notes(obj):
    """Sentences on mirrors that are not taken into account. Cheap enough for drawing."""
    return _read(obj)[1]


def images(obj):
    """[(3 x 3, (3,))] in object space: x is seen at matrix x + vector, for the mesh itself, which is the first, and
    each image that Mirror modifiers show of it. None of those of which notes() tells."""
    found = [(np.eye(3), np.zeros(3))]
    for plane in _read(obj)[0]:
        matrix, shift = motion.reflection(plane.row)
        found += [(matrix @ each, matrix @ moved + shift) for each, moved in found]
    return found


def whole(obj, shapes=()):
    """(WholeMesh of what is not posed, its triangles). shapes: n x 3 each; what one takes apart is not joined. @throws
    SceneError."""
    rest, faces, distance = shape_keys.rest_positions(obj.data), kept.faces(obj.data), obj.meanvalue.merge_distance
    welding.require_no_more_than_seams(rest, *faces, distance)
    copies = welding.together(kept.copies(obj, rest), shapes, distance)
    found = whole_mesh.WholeMesh(rest, copies, *seams(obj, rest, *faces, shapes, is_posed=False))
    return found, found.triangles(mesh_arrays.triangles(obj.data, rest))


def seams(obj, rest, corners, starts, shapes=(), is_posed=True):
    """(planes, twins) of a BindInput, (None, None) for none; rest, corners, starts as there. @throws SceneError.

    shapes: n x 3 each; a vertex that leaves the plane of a Mirror modifier in one of them is in no seam.
    is_posed: Symmetric counts too.
    """
    planes, joined = [], []
    for plane in _read(obj)[0]:
        far = max(plane.reach, IN_PLANE * point_sets.bounding_box_diagonal(rest))
        apart = (np.abs(shape.astype(np.float64) @ plane.row[:3] - plane.row[3]) for shape in (rest, *shapes))
        seam = np.logical_and.reduce([each <= far for each in apart])
        if whole_mesh.is_a_border(seam, corners, starts):
            planes.append(plane.row)
            joined.append(np.where(seam, np.arange(len(rest), dtype=np.int32), np.int32(-1)))
    symmetric = _symmetry(obj, planes) if is_posed else None
    if symmetric is not None:
        across = partners(obj, rest)
        missing = np.count_nonzero(across < 0)
        if missing:
            count = f"{missing:,} of {wording.vertices(len(rest))}"
            remedy = "See Select Problem Vertices > Unpaired, or turn Symmetric off"
            raise SceneError(f"{count} have no mirror image. {remedy}")
        for index, seam in enumerate(joined):
            is_seam = (seam >= 0) | (seam[across] >= 0)
            joined[index] = np.where(is_seam, np.arange(len(rest), dtype=np.int32), np.int32(-1))
        planes.append(symmetric)
        joined.append(across)
    return (np.array(planes), np.array(joined)) if planes else (None, None)


def partners(obj, rest, row=None):
    """n int32: the image of each vertex across a plane, else that of Symmetric, -1 for none; None without a plane."""
    row = row or _symmetry(obj)
    return row and kept.of(obj.data, "twins", lambda: whole_mesh.partners(rest, *kept.faces(obj.data), row), rest, row)


def _read(obj):
    """([Plane], [sentence])."""
    planes, found = [], []
    is_below = None  # the first modifier that moves or makes vertices
    for modifier in obj.modifiers:
        if modifier.type == 'MIRROR':
            _read_modifier(obj, modifier, is_below, planes, found)
        elif modifier.show_viewport and modifier.type not in KEEPING and is_below is None:
            is_below = modifier.name
    return planes, found


def _read_modifier(obj, modifier, below, planes, found):
    name = f"The seam of Mirror '{modifier.name}' is not held"
    if not modifier.show_viewport:
        if modifier.show_render:
            found.append(f"{name}: it is off in the viewport and on in renders. Turn it on to pose with it")
        return
    if below is not None:
        found.append(f"{name}: '{below}' comes before it. Move it to the top of the stack")
        return
    axes = [axis for axis in range(3) if modifier.use_axis[axis]]
    if any(modifier.use_bisect_axis[axis] for axis in axes):
        found.append(f"{name}: it cuts the mesh. Turn Bisect off, or delete the half that it cuts away")
        return
    mirror = modifier.mirror_object
    own = [_plane(obj, mirror, axis, modifier) for axis in axes]
    if None in own:
        found.append(f"{name}: '{mirror.name}' mirrors '{obj.name}' askew, by uneven scales. Apply them")
    elif not all(_is_square(plane.row[:3], other.row[:3]) for plane in own for other in planes):
        found.append(f"{name}: its plane does not stand at right angles to that of another Mirror")
    else:
        planes += own
        if mirror is not None and mirror.animation_data is not None and mirror.animation_data.action is not None:
            found.append(f"'{mirror.name}' of Mirror '{modifier.name}' is animated. A bake has its plane as it begins")


def _plane(obj, mirror, axis, modifier):
    """The Plane of a Mirror modifier, as Blender computes it; None if images are not congruent in object space."""
    reach = 0.5 * modifier.merge_threshold if modifier.use_mirror_merge else 0.0
    if mirror is None:
        return Plane((*(float(axis == each) for each in range(3)), 0.0), reach)
    to_object = np.array(obj.matrix_world.inverted_safe() @ mirror.matrix_world)
    if abs(np.linalg.det(to_object[:3, :3])) < 1e-30:
        return None
    across = to_object[:3, axis] / np.linalg.norm(to_object[:3, axis])
    normal = np.linalg.inv(to_object[:3, :3])[axis]
    normal = normal / np.linalg.norm(normal)
    if np.linalg.norm(np.cross(across, normal)) > RIGHT_ANGLE:
        return None
    far = np.abs(np.array([*obj.matrix_world.translation, *mirror.matrix_world.translation])).max()
    step = 2.0 ** math.ceil(math.log2(1e-6 * max(1e-30, far)))  # the same one while they are moved about
    distance = round(float(normal @ to_object[:3, 3]) / step) * step  # noise of the matrices is no new plane
    return Plane((*(float(round(each, 6)) for each in normal), distance), reach)


def _is_square(first, second):
    return abs(np.dot(first, second)) < RIGHT_ANGLE


def _symmetry(obj, planes=()):
    """The row of the plane of Symmetric; None if it is off, or a Mirror modifier has the same. @throws SceneError."""
    if obj.meanvalue.symmetric == 'NONE':
        return None
    row = (*(float(obj.meanvalue.symmetric == each) for each in 'XYZ'), 0.0)
    for plane in planes:
        if np.allclose(np.abs(plane[:3]), row[:3], atol=RIGHT_ANGLE) and abs(plane[3]) < 1e-9:
            return None
        if not _is_square(plane[:3], row[:3]):
            raise SceneError("Symmetric and the Mirror modifier are not at right angles. Choose another axis")
    return row
