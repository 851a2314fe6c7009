# SPDX-License-Identifier: GPL-3.0-or-later
"""From two objects and picked pairs to a WrapInput in the world, and back to a shape key of the first; and by that, to
shape keys of the other on the first. The overlay shows a line from each picked vertex to its place on the other."""

import dataclasses
import fnmatch

import bpy
import numpy as np
from mathutils import Vector

from ... import wording
from ...errors import ChangedMeanwhileError, SceneError, require_none
from ...scene import actions, key_marks, mesh_arrays, mirrors, rig_space, shape_keys, subject, vertex_groups
from ...scene.core import motion, point_sets
from ...scene.key_marks import Role
from ...scene.new_rest import adds_to
from ...scene.surface import Surface
from ...scene.views import COLORS
from ...solver import native_loader, session
from ...solver.core.fingerprint import digest
from ...widgets.overlay import NOTHING, Lines, draw_lines
from .wrapping import COSINE, LEAST_PAIRS, Wrap, WrapInput


class OfTwo:
    """In place of a Posing for widgets/background.py. target_name: of the other object; arrays: all that was read."""

    def require_unchanged(self, obj):
        """@throws ChangedMeanwhileError if one of both meshes is another by now."""
        target = bpy.data.objects.get(self.target_name)
        if target is None or digest(*type(self)(obj, target).arrays) != digest(*self.arrays):
            raise ChangedMeanwhileError(obj.name)


class Wrapping(OfTwo, Wrap):
    """whole: what of the mesh is fitted. @throws SceneError."""

    def __init__(self, obj, target):
        given, self.whole = gather(obj, target)
        super().__init__(given)
        self.target_name, self.arrays = target.name, [getattr(given, each.name) for each in dataclasses.fields(given)]


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
    evaluated = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh()
    try:
        shape, triangles = mesh_arrays.vertex_positions(mesh), mesh_arrays.shown_triangles(mesh)
    finally:
        evaluated.to_mesh_clear()
    pairs = obj.meanvalue.wrap.pairs
    whole, own_triangles = mirrors.whole(obj)
    picked, points = np.array([pair.vertex for pair in pairs], np.int32), np.array([pair.place for pair in pairs])
    if picked.max(initial=0) < len(obj.data.vertices):  # check() tells of others
        to_own = np.linalg.inv(to_world) @ subject.to_world(target)
        picked, points = whole.pairs(picked, motion.apply(to_own, points.reshape(-1, 3)))
    given = WrapInput(
        vertices=motion.apply(to_world, whole.rest),
        triangles=_outwards(own_triangles, to_world),
        target=motion.apply(subject.to_world(target), shape),
        target_triangles=_outwards(triangles, subject.to_world(target)),
        picked=picked,
        points=motion.apply(to_world, points.reshape(-1, 3)),
    )
    return given, whole


def write(obj, target, wrapped, whole):
    """The shape of Wrapped, of the whole, as a shape key at value 1. Returns its name. The key of the last wrap is
    written again; if it was edited meanwhile it is the artist's, and gets value 0."""
    shape = motion.apply(np.linalg.inv(subject.to_world(obj)), wrapped.positions)
    shape = np.asarray(whole.cut_back(shape), np.float32)
    return shape_keys.write_only(obj, Role.WRAP, _last(obj), target.name, shape).name


def _last(obj):
    """The shape key of the last wrap, or None."""
    keys, mark = obj.data.shape_keys, key_marks.mark(Role.WRAP)
    key = key_marks.only(keys, Role.WRAP)
    if key is None or shape_keys.is_as_written(key, Role.WRAP, mark):
        return key
    key.slider_min, key.value = 0.0, 0.0
    return None


def _outwards(triangles, to_world):
    """The triangles as a mirroring matrix leaves them."""
    return triangles if np.linalg.det(to_world[:3, :3]) > 0.0 else np.ascontiguousarray(triangles[:, ::-1])


#: Of the mesh's size: how far the wrapped shape may be from the other mesh on average; what moves less is still.
AWAY, STILL = 0.02, 1e-5

REFUSED = "Shape keys cannot be carried: {}"


def is_wrapped(obj):
    return key_marks.only(obj.data.shape_keys, Role.WRAP) is not None


class Carrying(OfTwo):
    """sliders: those of `source` that `obj` gets; left: names of those that it has."""

    def __init__(self, obj, source):
        """@throws SceneError."""
        if not is_wrapped(obj):
            raise SceneError("It is not known which place is which. Press Wrap Mesh first")
        self.target_name, (self._whole, triangles) = source.name, mirrors.whole(obj)
        theirs, faces = mirrors.whole(source)
        self.sliders, self.left = _chosen(obj, source)
        to_own = np.linalg.inv(subject.to_world(obj)) @ subject.to_world(source)
        wrapped = self._whole.start(shape_keys.positions(key_marks.only(obj.data.shape_keys, Role.WRAP)))
        shown = theirs.start(rig_space.shown_positions(source)), theirs.rest  # its keys may show by now, or no more
        surfaces = [Surface(motion.apply(to_own, each), faces) for each in shown]
        surface = min(surfaces, key=lambda each: each.nearest(wrapped)[3].mean())
        face, shares, _, away = surface.nearest(wrapped, Surface(wrapped, triangles).normals(), COSINE)
        lost = ~np.isfinite(away)
        face[lost], shares[lost], _, away[lost] = surface.nearest(wrapped[lost])
        if away.mean() > AWAY * point_sets.bounding_box_diagonal(surface.vertices):
            raise SceneError(f"'{source.name}' is not as it was at the last Wrap. Press Wrap Mesh again")
        shapes = vertex_groups.shapes_of(source, self.sliders).shapes()
        shapes = np.array([motion.apply(to_own, theirs.start(shape)) for shape in shapes])
        self._given = motion.apply(to_own, theirs.rest), shapes, faces, self._whole.rest, triangles, (face, shares)
        self.arrays = *self._given[:-1], face, shares, repr(self.sliders)

    def work(self, execution):
        """Steps (see solver/job.py) to {name: n x 3 float64 offset} of what moves. @throws SolverError."""
        start = native_loader.module().start_transfer
        shapes = yield from session.steps(start, *self._given, execution=execution, refused=REFUSED)
        rest = self._whole.cut_back(self._whole.rest)
        found, still = zip(self.sliders, shapes, strict=True), STILL * point_sets.bounding_box_diagonal(rest)
        moves = {slider.name: self._whole.cut_back(shape) - rest for slider, shape in found}
        return {name: move for name, move in moves.items() if np.abs(move).max(initial=0.0) > still}


def _chosen(obj, source):
    """As of Carrying. What masks a key there, and is not here, is part of its shape. @throws SceneError."""
    if source.data.shape_keys is None:
        raise SceneError(f"'{source.name}' has no shape keys to carry")
    wanted, keys = obj.meanvalue.wrap.keys or "*", source.data.shape_keys.key_blocks
    names = [key.name for key in keys if any(fnmatch.fnmatchcase(key.name, each.strip()) for each in wanted.split(","))]
    names = [name for name in names if name not in _not_carried(source)]
    held = _not_carried(obj) if obj.meanvalue.wrap.replace else set(obj.data.shape_keys.key_blocks.keys())
    found = [vertex_groups.slider_of(source, keys[name]) for name in names if name not in held]
    if not found:
        why = "here already. Turn on Replace" if names else f"called '{wanted}'. Choose others in Keys"
        raise SceneError(f"No shape key of '{source.name}' is carried: {'all are' if names else 'none is'} {why}")
    found = [dataclasses.replace(each, group="" if each.group in obj.vertex_groups else each.group) for each in found]
    return found, [name for name in names if name in held]


def _not_carried(obj):
    """Names of the reference key, and of those that the add-on writes."""
    keys = obj.data.shape_keys
    wrapped = [key.name for key in key_marks.of_role(keys, Role.WRAP)]
    return {keys.reference_key.name, *shape_keys.made_names(obj), *wrapped}


def write_carried(obj, source, offsets):
    """The keys of Carrying.work(), as they are on `source`; what adds to one that is replaced adds the same. The
    wrapped shape does not show any more. Returns names of those that are driven there and not here."""
    keys, theirs, made = obj.data.shape_keys, source.data.shape_keys, {}
    for name, offset in offsets.items():
        former, key = theirs.key_blocks[name], keys.key_blocks.get(name) or shape_keys.add_shape(obj, name, None)
        made[name], key.relative_key = key, made.get(former.relative_key.name, keys.reference_key)
        shape = (shape_keys.positions(key.relative_key) + offset).astype(np.float32)
        move = shape - shape_keys.positions(key)
        for each in [each for each in keys.key_blocks if each != key and adds_to(each, key, {key})]:
            shape_keys.write_positions(obj.data, each, shape_keys.positions(each) + move)
        shape_keys.write_positions(obj.data, key, shape)
        key.slider_min = 0.0 if key_marks.role(former) is not None else former.slider_min
        key.slider_max, key.value, key.mute = former.slider_max, former.value, former.mute
        key.vertex_group = former.vertex_group if former.vertex_group in obj.vertex_groups else ""
    own = {source: obj, source.data: obj.data, theirs: keys}
    key_marks.only(keys, Role.WRAP).value = 0.0  # drivers come last, since they may read other keys
    return [name for name, key in made.items() if not actions.copy_driver(theirs.key_blocks[name], key, own)]


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
    colors = np.array([(*COLORS[number % len(COLORS)], 1.0) for number in range(len(points))], np.float32)
    return Lines(np.stack([points, places], axis=1).reshape(-1, 3), np.repeat(colors, 2, axis=0))
