# SPDX-License-Identifier: GPL-3.0-or-later
"""The Grab tool among Blender's tools: whether it is chosen, choosing it, its settings; the circle around the mouse
that shows how far the surroundings follow; what would follow a press, while the mouse rests; and what is pressed on."""

from types import SimpleNamespace

import bpy
import gpu
import numpy as np
from bpy_extras import view3d_utils
from gpu_extras.presets import draw_circle_2d
from mathutils import Vector

from ...errors import MeanValueError, SceneError
from ...scene import mesh_arrays, pose_objects, rig_space, subject, views, worn
from ...scene.core.point_sets import tinted_faces
from ...widgets import picking
from ..bridge import control_places, limbs, new_handles, region, targets

TOOL = "meanvalue.grab"

#: Of Size, a share of the mesh's size, where the shape suggests nothing and the artist has not changed it.
FIRST_SIZE = 0.2

#: A limb that is shorter on the screen, at interface scale 1, is not suggested, but the one that it is on.
LEAST_PIXELS = 40.0


def _tool(context):
    return context.workspace.tools.from_space_view3d_mode('OBJECT', create=False) if context.workspace else None


def is_active(context):
    tool = _tool(context)
    return context.mode == 'OBJECT' and tool is not None and tool.idname == TOOL


def settings(context):
    """Properties of the tool's operator, or None where no 3D View was shown yet."""
    tool = _tool(context)
    return None if tool is None else tool.operator_properties(TOOL)


def fits(context):
    """Whether a press begins with the Size that the shape suggests: as long as the artist leaves the tool's alone."""
    return is_active(context) and abs(settings(context).size - FIRST_SIZE) < 1e-6


def size_at(context, obj, pressed):
    """The Size that a press begins with. From afar fingers are too small to be meant."""
    if not fits(context):
        return settings(context).size
    shown = pixels(*picking.view_of(context), pressed.place, 1.0)
    scale = shown * max(map(abs, obj.matrix_world.to_scale())) / context.preferences.system.ui_scale
    surface = region.Surface(obj, [pressed.vertex], is_pressed=True)
    found = surface.limb(limbs.least(obj, surface.seed, LEAST_PIXELS / max(scale, 1e-9))) or FIRST_SIZE
    whole = (1.0 - region.HANDLE_SHARE) * surface.diagonal
    return limbs.up_to_body(obj, surface.seed, found * whole) / whole


def choose(context):
    """Goes to Object Mode, where the tool is, as Blender's own step of undo."""
    if context.mode != 'OBJECT':
        bpy.ops.object.mode_set('EXEC_DEFAULT', True, mode='OBJECT')
    bpy.ops.wm.tool_set_by_id(name=TOOL, space_type='VIEW_3D')
    context.workspace.status_text_set(None)  # has the status bar drawn, which tells what the tool does


COLOR = (1.0, 1.0, 1.0, 0.8)

#: Pixels of the circle as long as nothing is known of what is pressed.
NOTICED = 12.0

#: Whether a circle is to be seen: the tool's own cursor stays away then.
is_shown = False


class DragCircle:
    """To be removed when the drag ends, however it ends."""

    def __init__(self):
        global is_shown
        self._center, self._radius, self._region = (0.0, 0.0), 0.0, 0
        self._handler = bpy.types.SpaceView3D.draw_handler_add(self._draw, (), 'WINDOW', 'POST_PIXEL')
        is_shown = True

    def show(self, region, view, mouse, place=None, length=0.0):
        """Around `mouse` (2, pixels in the region), of so much length in the world at `place`; 0: none. Without a
        place it only says that the press was noticed."""
        self._center, self._region = tuple(mouse), region.as_pointer()
        self._radius = NOTICED if place is None else pixels(region, view, place, length)
        views.draw_again('WINDOW')

    def remove(self):
        global is_shown
        is_shown = False
        bpy.types.SpaceView3D.draw_handler_remove(self._handler, 'WINDOW')
        views.draw_again('WINDOW')

    def _draw(self):
        if bpy.context.region.as_pointer() == self._region and self._radius > 0.0:
            draw(self._center, COLOR, self._radius)


def draw(center, color, radius):
    """In pixels of the region that is drawn."""
    gpu.state.blend_set('ALPHA')
    draw_circle_2d(center, color, radius, segments=64)
    gpu.state.blend_set('NONE')


def pixels(region, view, place, length):
    """How many pixels a length in the world is at `place`."""
    middle = view3d_utils.location_3d_to_region_2d(region, view, place)
    across = view.view_rotation @ Vector((length, 0.0, 0.0))
    beside = view3d_utils.location_3d_to_region_2d(region, view, place + across)
    return 0.0 if middle is None or beside is None else (beside - middle).length


#: How long the mouse has to rest.
REST_SECONDS = 0.1

#: Meshes of more vertices, with their modifiers, are not read before they are pressed.
MOST_VERTICES = 200_000

_found = None
_region = _mouse = None  # where the mouse was seen last: pointer of the region, (x, y) in the window


def would_follow(context, obj):
    """What would follow in the region that is drawn, or None: name of the object, place of the press in the world,
    size; tint, freedom and corners as of a Look of ui/overlay.py."""
    is_there = _found is not None and _found.name == obj.name and not is_shown
    is_there = is_there and _region == context.region.as_pointer() and is_active(context)
    return _found if is_there else None


def mouse_at(context, mouse):
    """The tool draws its cursor there. What is under the mouse is looked at once it rests: drawing must not."""
    global _region, _mouse
    if (_region, _mouse) != (context.region.as_pointer(), tuple(mouse)):
        _region, _mouse = context.region.as_pointer(), tuple(mouse)
        _stop()
        bpy.app.timers.register(_look, first_interval=REST_SECONDS)


def forget_hover():
    global _found
    _found = None
    _stop()


def _stop():
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)


def _look():
    """Timer, called once."""
    global _found
    before, _found = _found, None
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for each in area.regions:
                if each.as_pointer() == _region:
                    with bpy.context.temp_override(window=window, area=area, region=each):
                        _found = _find(bpy.context, (_mouse[0] - each.x, _mouse[1] - each.y))
    if before is not _found:
        views.draw_again('WINDOW')


def is_small(context, obj):
    """Whether it may be read without a press."""
    evaluated = obj.evaluated_get(context.view_layer.depsgraph)
    return max(len(obj.data.vertices), len(evaluated.data.vertices)) <= MOST_VERTICES


def _find(context, mouse):
    obj, view = subject.of(context), picking.view_of(context)
    is_asked = view is not None and is_active(context) and not is_shown
    if not is_asked or subject.object_problem(obj) is not None or not views.is_pressable(obj, context):
        return None
    try:
        pressed = picking.press(obj, *view, mouse) if is_small(context, obj) else None
        if pressed is None or new_handles.handle_at(obj, pressed.vertex) is not None:
            return None
        size = size_at(context, obj, pressed)
        surface = region.Surface(obj, [pressed.vertex], is_pressed=True)
        freedom = surface.falloff(size * surface.diagonal, region.HANDLE_SHARE).astype(np.float32)
    except MeanValueError:
        return None  # a press says why
    tint, corners = tinted_faces(mesh_arrays.shown_triangles(obj.data), freedom > 0.0)
    tint, freedom = rig_space.shown_positions(obj)[tint], freedom[tint]
    return SimpleNamespace(name=obj.name, place=pressed.place, size=size, tint=tint, freedom=freedom, corners=corners)


#: A press so near to a control, in pixels at interface scale 1, is meant for it, wherever the surface is.
CONTROL_PIXELS = 12.0


def find_view(context):
    """(region, view) as of picking.view_of(). @throws SceneError where there is none."""
    found = picking.view_of(context)
    if found is None:
        raise SceneError("Press in a single 3D View: Grab does not work in Quad View, and not beside it")
    return found


def find_pressed(context, mouse):
    """(mesh object, Pressed, name of the active mesh that it covers or "") at `mouse`, (2,) pixels in the region. The
    active mesh's controls come first. @throws SceneError where there is nothing to grab."""
    seen = *find_view(context), tuple(mouse)
    active = subject.of(context)
    is_usable = subject.object_problem(active) is None
    at_control = _control_under(context, active, *seen) if is_usable else None
    if at_control is not None:
        return active, at_control, ""
    obj, place = picking.first_object(context, *seen)
    if obj is None:
        if is_usable and len(active.data.polygons) == 0:
            raise SceneError(f"'{active.name}' has no faces, so there is no surface to press on. Give it some")
        raise SceneError("There is no surface under the mouse. Press on the mesh, or on the control of a handle")
    obj = pose_objects.of(obj) or obj
    below = worn.carrier(obj) or worn.body_of(obj, active)
    if below is not None and place is not None and views.is_pressable(below, context):
        place = below.matrix_world.inverted_safe() @ obj.matrix_world @ Vector(place)
        obj, place = below, np.array(place, np.float32)
    if problem := subject.problem_to_begin(obj) or subject.mode_problem(obj):
        raise SceneError(f"'{obj.name}' is under the mouse. {problem}, or hide it to reach what is behind it")
    pressed = picking.press(obj, *seen, place)
    if pressed is None:
        raise SceneError(f"'{obj.name}' has no surface of its own under the mouse. Press on its faces")
    is_apart = obj != active and is_usable and len(active.meanvalue.handles) > 0 and views.is_pressable(active, context)
    return obj, pressed, active.name if is_apart and picking.place_under(active, *seen) is not None else ""


def _control_under(context, obj, region, view, mouse):
    """The Pressed of a control of `obj` that is to be seen under the mouse, the nearest to it; or None."""
    found, least = None, CONTROL_PIXELS * context.preferences.system.ui_scale
    for handle in targets.followed_handles(obj):
        place = Vector(control_places.world_of(handle)[:3, 3])
        seen = view3d_utils.location_3d_to_region_2d(region, view, place)
        away = np.inf if seen is None else (seen - Vector(mouse)).length
        if away <= least and views.is_visible(handle.control, context.space_data):
            least, found = away, picking.Pressed(-1, place, handle.name)
    return found


def in_front(obj, covered):
    """A sentence on a press that may be meant for what is behind."""
    return f"'{obj.name}' is in front of '{covered}' here. Click it to make it the active object, or hide it"
