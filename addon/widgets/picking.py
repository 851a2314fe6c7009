# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that have the artist click at meshes, and what of a mesh is under the mouse."""

from dataclasses import dataclass, field

import bpy
import numpy as np
from bpy_extras import view3d_utils
from mathutils import Matrix, Vector

from .. import wording
from ..errors import MeanValueError, SceneError
from ..scene import kept, mirrors, rig_space, subject, views
from .background import VIEW_EVENTS
from .base import MeshOperator, ModalOperator


class PickingOperator(ModalOperator, MeshOperator):
    """Mix-in: what run(obj) works with is clicked, unless a script gives it.

    Subclasses define is_given(), whether nothing is to be clicked; prompt(obj), what the status bar asks for; and
    click(obj, view), of what view_under() found, which returns whether run() has all it needs. All raise
    MeanValueError, and those of clicks are told before the artist clicks again.
    """

    #: Whether it goes on after each run(), until Enter.
    repeats = False

    _has_run = False

    def take_back(self, obj):
        """Backspace. Returns whether anything has changed."""
        return False

    def invoke(self, context, _event):
        if self.is_given() or bpy.app.background or context.window is None:
            return self.execute(context)
        obj = subject.of(context)
        try:
            context.workspace.status_text_set(self.prompt(obj))
        except MeanValueError as error:
            return self.refuse(error)
        self.remember_object(obj)
        context.window.cursor_modal_set('EYEDROPPER')
        return self.begin(context)

    def react(self, context, event):
        looks_around = event.type in VIEW_EVENTS or (event.alt and event.type in {'LEFTMOUSE', 'RIGHTMOUSE'})
        if event.value != 'PRESS' or looks_around:
            return {'PASS_THROUGH'} if looks_around else {'RUNNING_MODAL'}
        if event.type in {'ESC', 'RIGHTMOUSE', 'RET', 'NUMPAD_ENTER'}:
            return {'FINISHED'} if self._has_run else {'CANCELLED'}
        if event.type not in {'LEFTMOUSE', 'BACK_SPACE'}:
            return {'RUNNING_MODAL'}
        obj = subject.of(context)
        if obj is None or obj.name != self._object_name:
            return self.refuse(SceneError("Another object is active now. Pick again"))
        view = view_under(context, event)
        if event.type == 'BACK_SPACE':
            self._has_run |= self.take_back(obj)
        elif view is not None and self.click(obj, view):
            if not self.repeats:
                return self.execute(context)
            self.run(obj)
            self._has_run = True
        context.workspace.status_text_set(self.prompt(obj))
        views.draw_again()
        return {'RUNNING_MODAL'}

    def failed(self, error):
        self.warn(error)
        return {'RUNNING_MODAL'}

    def end(self, context):
        super().end(context)
        if context.window is not None:
            context.window.cursor_modal_restore()
        views.draw_again('WINDOW')


def vertex_clicked(obj, view):
    """The vertex that was pressed. @throws SceneError beside the mesh."""
    return _required(press(obj, *view), obj).vertex


def place_clicked(obj, view):
    """Where the surface was pressed, (3,) in the object's own space. @throws SceneError beside the mesh."""
    return _required(place_under(obj, *view), obj)


def _required(found, obj):
    if found is None:
        raise SceneError(f"There is nothing of '{obj.name}' under the mouse. Click on its surface")
    return found


def require_vertex(obj, vertex):
    """@throws SceneError if the mesh has no vertex of that number."""
    count = len(obj.data.vertices)
    if not 0 <= vertex < count:
        raise SceneError(f"Vertex {vertex} is none of the {wording.vertices(count)} of '{obj.name}'")


#: Modifiers that show the mesh several times, or something else altogether.
COPYING = {'MIRROR', 'ARRAY', 'SCREW', 'PARTICLE_INSTANCE', 'NODES'}

#: An image is pressed if it is nearer than the mesh itself by more than rounding: they meet in the plane.
SAME = 1e-4


@dataclass(frozen=True)
class Pressed:
    """A vertex of a mesh object that was pressed: its number, and the place pressed in the world.

    handle  name of the handle whose control was pressed instead (the vertex is -1 then), or ""
    turn  3 x 3, what moves of the place in the world are of the vertex: a reflection where the place is on an image
    """

    vertex: int
    place: Vector
    handle: str = ""
    turn: Matrix = field(default_factory=lambda: Matrix.Identity(3))


def view_under(context, event):
    """(region, its RegionView3D, mouse in it) of the 3D View under the mouse, or None over panels and elsewhere."""
    for area in context.screen.areas if context.screen else ():
        if area.type != "VIEW_3D":
            continue
        under = [
            region
            for region in area.regions
            if min(region.width, region.height) > 1
            and 0 <= event.mouse_x - region.x < region.width
            and 0 <= event.mouse_y - region.y < region.height
        ]
        if len(under) == 1 and under[0].type == 'WINDOW' and not area.spaces.active.region_quadviews:
            mouse = event.mouse_x - under[0].x, event.mouse_y - under[0].y
            return under[0], area.spaces.active.region_3d, mouse
    return None


def view_of(context):
    """(region, its RegionView3D) of the 3D View that an operator was called in, or None. To be looked up at each event:
    what was kept of the interface may be gone by the next."""
    region, area = context.region, context.area
    if region is None or region.type != 'WINDOW' or area is None or area.type != 'VIEW_3D':
        return None
    return None if area.spaces.active.region_quadviews else (region, area.spaces.active.region_3d)


def place_under(obj, region, view, mouse):
    """Where the surface, as it is shown, is under the mouse, (3,) in the object's own space; or None."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return _hit(evaluated, obj.matrix_world, _ray(region, view, mouse))[1]


def press(obj, region, view, mouse, place=None):
    """The Pressed under the mouse, or at place_under(), of `obj` or an image of it; None on copies and beside it."""
    place = place_under(obj, region, view, mouse) if place is None else place
    found = None if place is None else vertex_or_image(obj, place)
    if found is None:
        return None
    vertex, turn = found
    to_world = obj.matrix_world.to_3x3()
    turn = to_world @ turn @ to_world.inverted_safe()
    return Pressed(vertex, obj.matrix_world @ Vector(place), turn=turn)


def first_object(context, region, view, mouse):
    """(the object to be seen under the mouse that can be pressed, its place_under(), None on an instance), or Nones."""
    least, found, ray = np.inf, (None, None), _ray(region, view, mouse)
    for instance in context.evaluated_depsgraph_get().object_instances:
        obj = instance.object  # gone at the next one; text and curves have an instance that is a mesh
        way, place = _hit(obj, instance.matrix_world, ray) if obj.type == 'MESH' else (np.inf, None)
        is_linked = instance.is_instance and obj.original.library is not None  # then the Empty alone is in the scene
        if way < least and views.is_pressable(instance.parent.original if is_linked else obj.original, context):
            least, found = way, (obj.original, None if instance.is_instance else place)
    return found


def _ray(region, view, mouse):
    origin = view3d_utils.region_2d_to_origin_3d(region, view, mouse)
    return origin, view3d_utils.region_2d_to_vector_3d(region, view, mouse)


def _hit(evaluated, to_world, ray):
    """(way as of rig_space.hit(), place in its own space) of a ray in the world, or (infinite, None)."""
    to_object = to_world.inverted_safe()
    origin, direction = to_object @ ray[0], to_object.to_3x3() @ ray[1]
    box = zip(evaluated.bound_box[0], evaluated.bound_box[6], origin, direction, strict=True)
    ways = [sorted(((low - at) / (step or 1e-30), (high - at) / (step or 1e-30))) for low, high, at, step in box]
    if max(way for way, _ in ways) > min(way for _, way in ways):
        return np.inf, None
    origin, direction = np.array(origin, np.float64), np.array(direction, np.float64)
    way = rig_space.hit(evaluated, origin, direction)
    return way, np.array(origin + way * direction, np.float32) if way < np.inf else None


def vertex_or_image(obj, place):
    """(vertex, 3 x 3 Matrix) of a place on what is shown of `obj`, (3,) in its own space: the vertex that is nearest
    there, itself or its image in Mirror modifiers, and what turns moves there into its own. None on all other copies.
    """
    positions, (corners, starts) = rig_space.shown_positions(obj), kept.faces(obj.data)
    least, found = np.inf, None
    for matrix, shift in mirrors.images(obj):
        own = (matrix.T @ (place - shift)).astype(np.float32)
        x, y, z = (positions - own).T
        distances = np.sqrt(x * x + y * y + z * z)
        if len(corners) and not (corners == distances.argmin()).any():
            # What a loose vertex holds is not what was pressed.
            distances[np.bincount(corners, minlength=len(distances)) == 0] = np.inf
        if distances.min(initial=np.inf) < (1.0 - SAME) * least:
            least, found = distances.min(), (distances, matrix.T)
    if found is None:
        return None
    distances, turn = found
    copying = {each.type for each in obj.modifiers if each.show_viewport} & COPYING
    if rig_space.is_there(obj):  # the surface is known at rest alone, and Smooth by Angle copies nothing
        copying -= {'NODES'}
    if copying:  # what copies a mesh tells nothing of what is a copy: on the mesh a face is as near as it is large
        ends = positions[corners]
        extents = np.maximum.reduceat(ends, starts) - np.minimum.reduceat(ends, starts)
        if not (np.minimum.reduceat(distances[corners], starts) <= np.linalg.norm(extents, axis=1)).any():
            return None
    return int(distances.argmin()), Matrix(turn.tolist())
