# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a mesh is under the mouse, for operators that have the artist click at it."""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Vector

from ..bridge import mesh_arrays, overlay_data, views

#: A ray goes on behind what is not to be seen, this share of its way farther, and through so many such objects.
BEHIND = 1e-5
MOST_HIDDEN = 100


@dataclass(frozen=True)
class Pressed:
    """A vertex of a mesh object that was pressed: its number, the place pressed in the world, and the view.

    line  name of the handle whose control was pressed instead (the vertex is -1 then), or None
    """

    vertex: int
    place: Vector
    region: object
    view: object
    line: str | None = None


def view_under(context, event):
    """(region, its RegionView3D, mouse in it) of the 3D View under the mouse, or None over panels and elsewhere."""
    for area in context.screen.areas if context.screen else ():
        if area.type != "VIEW_3D":
            continue
        under = [region for region in area.regions if _is_in(region, event)]
        if len(under) == 1 and under[0].type == 'WINDOW' and not area.spaces.active.region_quadviews:
            mouse = event.mouse_x - under[0].x, event.mouse_y - under[0].y
            return under[0], area.spaces.active.region_3d, mouse
    return None


def view_pressed(context, event):
    """As view_under(), for an operator that the press itself has called.

    Blender has found out then whose press it is: toolbar and sidebar let it through where they are transparent.
    """
    region, area = context.region, context.area
    is_sure = region is not None and area is not None and area.type == 'VIEW_3D' and region.type == 'WINDOW'
    if not is_sure or not _is_in(region, event) or area.spaces.active.region_quadviews:
        return view_under(context, event)
    return region, area.spaces.active.region_3d, (event.mouse_x - region.x, event.mouse_y - region.y)


def place_under(obj, region, view, mouse):
    """Where the surface, as it is shown, is under the mouse, (3,) in the object's own space; or None."""
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    to_object = obj.matrix_world.inverted_safe()
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    is_hit, place, _normal, _face = evaluated.ray_cast(to_object @ origin, to_object.to_3x3() @ direction)
    return np.array(place, np.float32) if is_hit else None


def vertex_under(obj, region, view, mouse):
    """The vertex nearest to place_under(), or None."""
    place = place_under(obj, region, view, mouse)
    return None if place is None else _nearest_vertex(obj, place)


def press(obj, region, view, mouse):
    """The Pressed of the surface of `obj` under the mouse, or None."""
    place = place_under(obj, region, view, mouse)
    if place is None:
        return None
    return Pressed(_nearest_vertex(obj, place), obj.matrix_world @ Vector(place), region, view)


def first_object(context, region, view, mouse):
    """The object whose surface is to be seen under the mouse, or None."""
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, mouse)
    depsgraph = context.evaluated_depsgraph_get()
    for _ in range(MOST_HIDDEN):
        is_hit, place, _normal, _face, obj, _matrix = context.scene.ray_cast(depsgraph, origin, direction)
        if not is_hit:
            return None
        obj = obj.original
        if views.is_visible(obj, context.space_data):
            return obj
        origin = place + BEHIND * max(1.0, (place - origin).length) * direction
    return None


def _nearest_vertex(obj, place):
    """Of those that faces have: what a loose one holds is not what was pressed."""
    distances = np.linalg.norm(overlay_data.shown_positions(obj) - place, axis=1)
    corners, _starts = mesh_arrays.faces(obj.data)
    if len(corners):
        is_loose = np.ones(len(distances), bool)
        is_loose[corners] = False
        distances[is_loose] = np.inf
    return int(distances.argmin())


def _is_in(region, event):
    return (
        region.width > 1
        and region.height > 1
        and 0 <= event.mouse_x - region.x < region.width
        and 0 <= event.mouse_y - region.y < region.height
    )
