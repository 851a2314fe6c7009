# SPDX-License-Identifier: GPL-3.0-or-later
"""The vertex group that is the region of influence, and how far it grows from a handle."""

import bpy
import numpy as np

from ... import ids
from ...errors import SceneError
from ...live import engine
from ...scene import kept, mesh_arrays, object_model, shape_keys, vertex_groups
from ...scene.core import motion, point_sets
from ...solver import native_loader
from . import limbs, members

#: How far the handle of Grab itself reaches, as a share of Size. A handle of several vertices can turn the mesh.
HANDLE_SHARE = 0.15

#: Pieces of a mesh that are no farther apart than this share of its size nearly touch.
NEARLY = 0.005

#: No limb is longer than this share of the mesh's size.
LONGEST_LIMB = 0.8

#: A piece is worn by another that is larger, if half of it is no farther from that than the first share of the mesh's
#: size. A press is meant for what is below it up to the last. So many vertices stand for a piece, so many pieces wear.
#: Walls of one shell face away from each other by that cosine, and are no farther apart than that share of the size.
FAR, SMALLER, CLOSE = 0.08, 0.95, 0.02
SAMPLES, MOST_BODIES = 64, 4
FACING, THICKEST = 0.5, 0.03


def require_own_group(obj):
    """@throws SceneError if the region is the vertex group of a handle, which writing to the region would change."""
    name = obj.meanvalue.roi_group
    if any(handle.name == name and not handle.mark for handle in obj.meanvalue.handles):
        raise SceneError(f"The region '{name}' is the vertex group of a handle too. Choose another, or clear the field")


def ensure_group(obj):
    """The region's vertex group, made if it is missing and put into the settings."""
    settings = obj.meanvalue
    group = obj.vertex_groups.get(settings.roi_group)
    if group is None:
        group = vertex_groups.make(obj, settings.roi_group or ids.REGION_GROUP)
        settings.roi_group = settings.made_region = group.name
    return group


def remove_made_group(obj):
    """Clears the region, and deletes its vertex group if it was made for it."""
    settings = obj.meanvalue
    if settings.roi_group == settings.made_region:
        vertex_groups.remove_made(obj, settings.made_region)
    settings.roi_group = settings.made_region = ""


def weights(obj):
    """n float64, 0 to 1: how freely each vertex may move by the settings; all 0 without a region, or its group."""
    if kept.has_any():
        bpy.context.view_layer.update()  # Blender has told of all edits then
    return known_weights(obj, 0.0)


def known_weights(obj, without):
    """The same where Blender has told of all edits; without: what there is without a region."""
    name = obj.meanvalue.roi_group
    found = vertex_groups.weights(obj, [name]).get(name)
    return np.full(len(obj.data.vertices), without) if found is None else found


class Surface:
    """The mesh over which regions grow from the vertices `seeds`: its rest shape, of that `diagonal`, copies merged.

    Distances go over edges, and over to another piece of the mesh where two touch or nearly touch, as clothes do.
    is_pressed: what is worn and lies close stands for what is below it, which is the seed then.
    """

    def __init__(self, obj, seeds, is_pressed=False):
        self._first, (self._ways, self.diagonal, self._below, gaps, self._asked) = _ways(obj)
        held = np.concatenate([seeds, *members.of(obj, [each for each in obj.meanvalue.handles if each.is_enabled])])
        held = held if self._first is None else self._first[held]
        if is_pressed:
            held[0] = self._below[held[0]] if gaps[held[0]] <= CLOSE * self.diagonal else held[0]
        self._seeds, self._held, self.seed, self._obj = held[: len(seeds)], held, int(held[0]), obj

    def below(self):
        """n int32: for each vertex of what is worn, one of the piece that wears it, about the nearest; -1 elsewhere."""
        return self._of_mesh(self._below)

    def distances(self, limit, share=1.0):
        """n float64: how far each vertex is from the seeds, over the rest shape, as long as that is within a share of
        `limit`; below 0 in pieces without a seed that lie completely within the limit. Other numbers are larger."""
        is_one_piece = (self._ways.parts == self._ways.parts[0]).all()
        return self._of_mesh(self._ways.distances(self._seeds, share * limit if is_one_piece else limit))

    def falloff(self, limit, free=0.0):
        """n float64, 0 to 1: how much follows, all up to the share `free` of the limit; at least the next edges do.
        All of what is worn and not held does where anything below it does: clothes, and all that rides on a rig."""
        asked, parts = (*self._seeds.tolist(), limit, free), self._ways.parts
        if asked not in self._asked:  # the last one is kept
            self._asked.clear()
            self._asked[asked] = self._ways.falloff(self._seeds, limit, free)
        found = self._asked[asked].copy()
        worn = parts[(self._below >= 0) & (found[self._below] > 0.0)]
        if len(worn):
            found[np.isin(parts, worn) & ~np.isin(parts, parts[self._held])] = 1.0
        return np.maximum(self._of_mesh(found), limbs.riding(self._obj, self._seeds, (1.0 - free) * limit))

    def reach_through(self, thickness):
        """Where the mesh is a wall no thicker than that, as of a cup or a coat, the place across is a seed, too."""
        rest, (corners, starts) = shape_keys.rest_positions(self._obj.data), kept.faces(self._obj.data)
        thickness, away = min(thickness, THICKEST * self.diagonal), np.abs(rest - rest[self.seed]).max(axis=1)
        counts, own = np.diff(starts, append=len(corners)), np.flatnonzero(corners == self.seed)
        if len(own) == 0:
            return
        at_seed = np.searchsorted(starts, own, "right") - 1
        reach = thickness + max(away[corners[starts[face] :][: counts[face]]].max() for face in at_seed)
        is_near = np.logical_or.reduceat((away <= reach)[corners], starts)
        begins, counts = starts[is_near], counts[is_near]
        fans = [begins[counts > k + 1, None] + (0, k, k + 1) for k in range(1, counts.max() - 1)]
        used, faces = np.unique(np.concatenate([corners[fan] for fan in fans]), return_inverse=True)
        near, faces, seed = rest[used], faces.reshape(-1, 3).astype(np.int32), np.searchsorted(used, self.seed)
        areas = np.cross(*(near[faces[:, k]] - near[faces[:, 0]] for k in (1, 2)))
        normal = motion.unit(areas[(faces == seed).any(axis=1)].sum(axis=0))
        found = native_loader.module().Surface(near, faces).nearest(near[seed, None], -normal[None], FACING)
        across, shares, gap = (each[0] for each in found)
        if gap <= thickness and (near[seed] - shares @ near[faces[across]]) @ normal >= FACING * gap:
            place = used[faces[across, np.argmax(shares)]]
            self._seeds = np.append(self._seeds, place if self._first is None else self._first[place])

    def limb(self, least):
        """How far the limb goes that the first seed is on, up to the body, as a share of the diagonal; 0 where there is
        none of at least such a length."""
        return self._ways.limb(self.seed, least, LONGEST_LIMB * self.diagonal) / self.diagonal

    def _of_mesh(self, values):
        """Values of the merged vertices, given to all copies of each."""
        return values if self._first is None else values[self._first]


def _ways(obj):
    """(copies as of seams, what _made_ways() makes of the mesh in which they are merged); kept."""
    rest = shape_keys.rest_positions(obj.data)
    first = kept.copies(obj, rest)
    return first, kept.of(obj.data, "ways", lambda: _made_ways(obj, rest, first), rest, *kept.seam_settings(obj))


def _made_ways(obj, rest, first):
    """(SurfaceWays, the mesh's diagonal, Surface.below(), how far it is there, {what of its falloff is known})."""
    edges = mesh_arrays.edges(obj.data)
    if first is not None:
        edges = first[edges]
        edges = edges[edges[:, 0] != edges[:, 1]]
    make, none = native_loader.module().SurfaceWays, np.empty((0, 3), np.int32)
    ways, diagonal = make(rest, edges, none), point_sets.bounding_box_diagonal(rest)
    below, gaps = np.full(len(rest), -1, np.int32), np.full(len(rest), np.inf)
    if np.count_nonzero(np.bincount(ways.parts) > 1) > 1:
        triangles = mesh_arrays.triangles(obj.data, rest)
        triangles = triangles if first is None else first[triangles]
        ways = make(rest, edges, triangles, gap=NEARLY * diagonal)
        _find_below(np.nan_to_num(rest), triangles, ways.parts, FAR * diagonal, below, gaps)
    return ways, diagonal, below, gaps, {}


def _find_below(rest, triangles, parts, far, below, gaps):
    """Fills in Surface.below(), and how far that is."""
    triangles = triangles[np.argsort(parts[triangles[:, 0]], kind="stable")]
    begins = np.flatnonzero(np.diff(parts[triangles[:, 0]], prepend=-1))
    pieces = [(faces, np.unique(faces)) for faces in np.split(triangles, begins[1:])]
    sizes = {of[0]: point_sets.bounding_box_diagonal(rest[of]) for _, of in pieces}
    pieces.sort(key=lambda piece: -sizes[piece[1][0]])
    bodies = 0
    for number, (faces, body) in enumerate(pieces):
        if below[body[0]] >= 0 or bodies == MOST_BODIES:
            continue
        bodies += 1
        surface = native_loader.module().Surface(rest, faces)
        for _, of in pieces[number + 1 :]:
            may_be_worn = below[of[0]] < 0 and sizes[of[0]] < SMALLER * sizes[body[0]]
            if may_be_worn and np.median(surface.nearest(rest[of[:: 1 + len(of) // SAMPLES]])[2]) <= far:
                under, weights, gaps[of] = surface.nearest(rest[of])
                below[of] = faces[under, np.argmax(weights, axis=1)]


def write(obj, weights):
    """Makes the region exactly n `weights`, bool or 0 to 1: in a new group, where that of before is the artist's."""
    settings = obj.meanvalue
    with engine.held(), kept.writing(obj):
        if settings.roi_group in obj.vertex_groups and settings.roi_group != settings.made_region:
            settings.roi_group = settings.made_region = vertex_groups.make(obj, ids.REGION_GROUP).name
        vertex_groups.replace_weights(obj, ensure_group(obj), np.asarray(weights, np.float64))
    for model in object_model.known_models(obj):
        model.edited()
    obj.update_tag(refresh={'OBJECT'})  # for Live; without, the mesh too is told of as edited


def radius(obj, size):
    """`size`, a share of the diagonal of the mesh at rest, as a length."""
    return size * point_sets.bounding_box_diagonal(shape_keys.rest_positions(obj.data))


def shown_size(obj):
    """The diagonal of the mesh's box with its modifiers: quick to get, for what is only shown."""
    return float(np.linalg.norm(np.ptp(np.array(obj.bound_box), axis=0)))


def around(obj, *handles):
    """n float, 0 to 1: the surroundings of handles, each as far as its `size` says. Nearer vertices have more. Pieces
    that lie completely within that, as eyes in a head, have 1."""
    found = np.zeros(len(obj.data.vertices))
    handles = [handle for handle in handles if handle.size > 0.0]
    for handle, seeds in zip(handles, members.of(obj, handles), strict=True):
        if len(seeds):
            surface = Surface(obj, seeds)
            found = np.maximum(found, surface.falloff((1.0 - HANDLE_SHARE) * (handle.size * surface.diagonal)))
    return found


def without(obj, handle, weights):
    """The region's `weights` (n float) without the surroundings of one handle. They stay as they are if the artist has
    painted there: if they differ from what the sizes of the handles give."""
    own = around(obj, handle)
    others = around(obj, *(other for other in obj.meanvalue.handles if other != handle))
    is_own = own > 0.0
    is_as_made = np.abs(np.maximum(own, others) - weights)[is_own] <= 1.01 / vertex_groups.WEIGHT_STEPS
    return np.where(is_own, others, weights) if is_as_made.all() else weights


def let_go(obj, handle):
    """Takes the surroundings of a handle out of a region that the add-on made, which goes with the last of them."""
    settings = obj.meanvalue
    is_ours = settings.roi_group in obj.vertex_groups and settings.roi_group == settings.made_region
    if handle.size == 0.0 or not is_ours or obj.data.is_editmode:
        return
    left = without(obj, handle, weights(obj))
    if left.any():
        write(obj, left)
    else:
        remove_made_group(obj)
