# SPDX-License-Identifier: GPL-3.0-or-later
"""From two objects and picked pairs to a WrapInput in the world, and back to a shape key of the first. The overlay
shows a line from each picked vertex to its place on the other object."""

import bpy
import numpy as np
from mathutils import Vector

from ... import ids, wording
from ...errors import SceneError, require_none
from ...scene import kept, key_marks, mesh_arrays, mirrors, rig_space, shape_keys, subject, vertex_groups, views
from ...scene.core import motion, welding, whole_mesh
from ...scene.key_marks import Role
from ...solver.core.fingerprint import digest
from ...widgets.overlay import NOTHING, Lines, draw_lines
from ..core.wrap_input import LEAST_PAIRS, WrapInput
from .wrapping import Wrap


class Wrapping(Wrap):
    """In place of a Posing for widgets/background.py. whole: what of the mesh is fitted. @throws SceneError."""

    def __init__(self, obj, target):
        given, self.whole = gather(obj, target)
        super().__init__(given)
        self.target_name = target.name

    def require_unchanged(self, obj):
        """@throws SceneError if one of both meshes is another by now."""
        target = bpy.data.objects.get(self.target_name)
        if target is None or _key(gather(obj, target)[0]) != _key(self.given):
            raise SceneError(
                f"'{obj.name}' or '{self.target_name}' was changed meanwhile, so the result is dropped. Try again"
            )


def target_problem(obj):
    """Why there is no mesh that `obj` can be wrapped onto, or None. Cheap enough for drawing."""
    try:
        _require_ready(obj, target_of(obj))
    except SceneError as error:
        return str(error)
    return None


def pairs_problem(obj):
    """Why the pairs that are picked do not do, or None."""
    count = len(obj.meanvalue.wrap.pairs)
    if 0 < count < LEAST_PAIRS:
        pairs = wording.counted(count, "pair is", "pairs are")
        return f"{pairs} picked, at least {LEAST_PAIRS} are needed. Pick more, or clear them"
    return None


def target_of(obj):
    """The object that `obj` takes the shape of: that of the settings, or else the other mesh that is selected.

    @throws SceneError.
    """
    return subject.other_mesh(bpy.context, obj, obj.meanvalue.wrap.target)


def _require_ready(obj, target):
    if target.data.is_editmode:
        raise SceneError(f"'{target.name}' is in Edit Mode. Leave that first")
    require_none(shape_keys.absolute_problem(obj))


def gather(obj, target):
    """(WrapInput in the world, not checked, what of the mesh that is fitted, see scene/core/whole_mesh.py): the rest
    shape of `obj`, `target` as it is shown. @throws SceneError."""
    _require_ready(obj, target)
    to_world = subject.to_world(obj)
    rest, faces = shape_keys.rest_positions(obj.data), mesh_arrays.faces(obj.data)
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        shape, triangles = mesh_arrays.vertex_positions(mesh), mesh_arrays.shown_triangles(mesh)
    finally:
        evaluated.to_mesh_clear()
    pairs = obj.meanvalue.wrap.pairs
    welding.require_no_more_than_seams(rest, *faces, obj.meanvalue.merge_distance)
    whole = whole_mesh.of(rest, kept.copies(obj, rest), *mirrors.seams(obj, rest, *faces, is_posed=False))
    picked, points = np.array([pair.vertex for pair in pairs], np.int32), np.array([pair.place for pair in pairs])
    if picked.max(initial=0) < len(rest):  # check() tells of others
        to_own = np.linalg.inv(to_world) @ subject.to_world(target)
        picked, points = whole.pairs(picked, motion.apply(to_own, points.reshape(-1, 3)))
    given = WrapInput(
        vertices=motion.apply(to_world, whole.rest),
        triangles=_outwards(whole.triangles(mesh_arrays.triangles(obj.data, rest)), to_world),
        target=motion.apply(subject.to_world(target), shape),
        target_triangles=_outwards(triangles, subject.to_world(target)),
        picked=picked,
        points=motion.apply(to_world, points.reshape(-1, 3)),
    )
    return given, whole


def write(obj, target, wrapped, whole, tolerance):
    """The shape of Wrapped, of the whole, as a shape key at value 1, and the group of what is farther than `tolerance`.

    The key of the last wrap is written again; if it was edited meanwhile it is the artist's, and gets value 0.
    Returns (the key's name, how many vertices are in the group).
    """
    shape = motion.apply(np.linalg.inv(subject.to_world(obj)), wrapped.positions)
    shape = np.asarray(whole.cut_back(shape), np.float32)
    key = _last(obj) or shape_keys.add_shape(obj, target.name, shape)
    key.slider_min = key_marks.mark(Role.WRAP)
    key_marks.claim(key)
    shape_keys.write_positions(obj.data, key, shape)
    shape_keys.show_fully(obj.data.shape_keys, key)
    obj.meanvalue.wrap.made = ""
    left_over = wrapped.distance[whole.places] > tolerance
    group = obj.vertex_groups.get(ids.LEFT_OVER_GROUP)
    if group is None and left_over.any():
        group = obj.vertex_groups.new(name=ids.LEFT_OVER_GROUP)
    if group is not None:
        vertex_groups.replace_weights(obj, group, left_over)
    return key.name, np.count_nonzero(left_over)


def _last(obj):
    """The shape key of the last wrap, or None."""
    keys, mark = obj.data.shape_keys, key_marks.mark(Role.WRAP)
    key = key_marks.only(keys, Role.WRAP)
    if key is None and keys is not None and obj.meanvalue.wrap.made:  # of before such keys had marks
        key = keys.key_blocks.get(obj.meanvalue.wrap.made)
        is_of_wrap = key is not None and key != keys.reference_key and key_marks.role(key) is None
        return key if is_of_wrap else None
    if key is None or shape_keys.is_as_written(key, Role.WRAP, mark):
        return key
    key.slider_min, key.value = 0.0, 0.0
    return None


def _key(given):
    return digest(given.vertices, given.triangles, given.target, given.target_triangles, given.picked, given.points)


def _outwards(triangles, to_world):
    """The triangles as a mirroring matrix leaves them."""
    return triangles if np.linalg.det(to_world[:3, :3]) > 0.0 else np.ascontiguousarray(triangles[:, ::-1])


#: Size of what ends a line, at interface scale 1.
END_PIXELS = 8.0

#: (name of an object, its vertex whose place is to be clicked next), or None.
begun = None


def paint(context, obj):
    draw_lines(context, obj, lines(obj), END_PIXELS)


def lines(obj):
    """The Lines of a mesh object, from where its vertices are to be seen now to where the other object is now.

    A vertex whose place is still missing has a line of no length.
    """
    settings = obj.meanvalue.wrap
    count = len(obj.data.vertices)
    pairs = [pair for pair in settings.pairs if pair.vertex < count] if settings.target is not None else []
    alone = [begun[1]] if begun is not None and begun[0] == obj.name and begun[1] < count else []
    if not pairs and not alone:
        return NOTHING
    points = rig_space.shown_positions(obj)[[*(pair.vertex for pair in pairs), *alone]]
    places = points.copy()
    if pairs:
        to_own = obj.matrix_world.inverted_safe() @ settings.target.matrix_world
        places[: len(pairs)] = [to_own @ Vector(pair.place) for pair in pairs]
    colors = np.array([(*views.COLORS[number % len(views.COLORS)], 1.0) for number in range(len(points))], np.float32)
    return Lines(np.stack([points, places], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))
