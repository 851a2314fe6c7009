# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes hold of the mesh where it is pressed, and drags it: the operator of the Grab tool."""

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

from ... import ids
from ...errors import MeanValueError, SceneError, require_none
from ...live import engine
from ...scene import kept, pose_object_making, pose_objects, subject
from ...widgets import picking
from ...widgets.base import ModalOperator
from ..bridge import controls, new_handles, region, scene_input
from ..bridge.grip import Grip
from . import tool_choice
from .handles import insert_keyframes
from .tool_choice import DragCircle

#: What a notch of the wheel makes of Size.
WHEEL_STEP = 1.15

#: How often Size and status are looked at in a drag: not at every notch of the wheel, for which the mesh is bound anew.
TICK_SECONDS = 0.1

GROW = {'WHEELUPMOUSE', 'RIGHT_BRACKET', 'NUMPAD_PLUS', 'PAGE_UP'}
SHRINK = {'WHEELDOWNMOUSE', 'LEFT_BRACKET', 'NUMPAD_MINUS', 'PAGE_DOWN'}

#: Limits of Size, a share of the mesh's size.
LEAST_SIZE, MOST_SIZE = 0.005, 3.0


class MEANVALUE_OT_grab(ModalOperator, bpy.types.Operator):
    """Press on the mesh and drag: what is under the mouse becomes a handle, and its surroundings follow"""

    bl_label = "Grab"

    vertex: bpy.props.IntProperty(
        name="Vertex", description="The vertex that is pressed", default=-1, min=-1, options={'HIDDEN'}
    )
    #: Adjusting the operator runs it again from before, when another object may have been the active one.
    object_name: bpy.props.StringProperty(
        name="Object", description="The mesh object. If empty: the active one", options={'HIDDEN'}
    )
    size: bpy.props.FloatProperty(
        name="Size",
        description="How far the surroundings follow, as a share of the mesh's size. By default that of the limb there",
        default=tool_choice.FIRST_SIZE,
        min=LEAST_SIZE,
        soft_max=1.0,
        max=MOST_SIZE,
        subtype='FACTOR',
    )
    offset: bpy.props.FloatVectorProperty(
        name="Move", description="How far the handle is moved, in the world", subtype='TRANSLATION'
    )
    handle: bpy.props.StringProperty(
        name="Handle",
        description="Vertex group of the handle to move. If empty: the one that has the vertex, or else a new one",
        maxlen=ids.NAME_LENGTH,
        options={'HIDDEN'},
    )

    pin: bpy.props.BoolProperty(
        name="Pin",
        description="Pin the mesh there, or let go of the pin that is there, in place of grabbing it",
        options={'HIDDEN'},
    )
    choose_tool: bpy.props.BoolProperty(
        name="Choose Tool", description="Only make Grab the active tool, in Object Mode", options={'HIDDEN'}
    )

    _grip = _circle = _pressed = None

    def execute(self, context):
        """All at once, for scripts and the last-operation panel."""
        try:
            if context.mode != 'OBJECT':
                raise SceneError("Grab works in Object Mode. Go back to Object Mode")
            obj = context.view_layer.objects.get(self.object_name) if self.object_name else subject.of(context)
            obj = pose_objects.of(obj) or obj
            require_none(subject.problem_to_begin(obj) or subject.mode_problem(obj))
            if pose_objects.is_foreign(obj) or self.handle not in obj.meanvalue.handles:
                picking.require_vertex(obj, self.vertex)
            with pose_object_making.ready(obj) as (obj, made):
                if self.pin:
                    message = new_handles.toggle_pin(obj, self.vertex, self.size, self.handle)
                    if obj != subject.of(context):
                        subject.choose(obj)
                    return self.tell([message, *made], [])
                grip = Grip(obj, self.vertex, self.size, self.handle)
                if self.properties.is_property_set("size"):
                    grip.resize(obj, self.size)
                grip.move(obj, Vector(self.offset))
                _select_control(context, obj, grip)
        except MeanValueError as error:
            return self.refuse(error)
        return self.tell(*_outcome(obj, grip, Vector(self.offset), made))

    def invoke(self, context, event):
        if self.choose_tool or context.mode != 'OBJECT':
            tool_choice.choose(context)
            return {'CANCELLED'}  # there is nothing to undo or to adjust
        self._mouse = self._start = Vector((event.mouse_region_x, event.mouse_region_y))
        try:
            if self.pin:
                obj = self._press(context)
                if self._covered:
                    raise SceneError(tool_choice.in_front(obj, self._covered))
                return self.execute(context)
            view = tool_choice.find_view(context)
        except SceneError as error:
            return self.warn(error)
        self._circle = DragCircle()
        self._circle.show(*view, self._mouse)  # what is under the mouse is looked at next: large meshes take a while
        return self.begin(context, TICK_SECONDS)

    def _press(self, context):
        """Finds what was pressed on. Returns the object. @throws SceneError."""
        obj, self._pressed, self._covered = tool_choice.find_pressed(context, self._start)
        self.object_name = pose_objects.shown(obj).name  # a pose object may be made for it
        self.remember_object(obj)
        self.vertex = self._pressed.vertex
        held = None if self._pressed.handle or pose_objects.is_foreign(obj) else new_handles.handle_at(obj, self.vertex)
        self.handle = self._pressed.handle if held is None else obj.meanvalue.handles[held].name
        self._fits = self._is_to_fit = not (self.handle or self.pin) and tool_choice.fits(context)
        if not self.pin:
            self._whole = region.radius(obj, 1.0)  # kept: a move of the mouse must not read the whole mesh
            if tool_choice.is_small(context, obj):
                self._fit(context, obj)
            tool_choice.forget_hover()
            self.size = self._size_taken = (self.handle and obj.meanvalue.handles[self.handle].size) or self.size
        return obj

    def failed(self, error):
        self.warn(error)
        return {'CANCELLED'} if self._grip is None else {'FINISHED'}  # what was made can be undone

    def react(self, context, event):
        if event.type in {'ESC', 'RIGHTMOUSE'} and event.value == 'PRESS':
            return self._give_up(context)
        obj = self._press(context) if self._pressed is None else self.object()
        if event.type == 'LEFTMOUSE' and event.value == 'RELEASE':
            return self._let_go(context, obj)
        is_timer = 'TIMER' in event.type  # it may be another operator's
        if event.type == 'MOUSEMOVE':
            self._drag(context, event, obj)
        elif event.value == 'PRESS' and event.type in GROW | SHRINK:
            self._resize(context, 1.0 if event.type in GROW else -1.0)
        elif is_timer:
            self._take_size(obj)
        self._show(context, obj)
        return {'PASS_THROUGH'} if is_timer else {'RUNNING_MODAL'}

    def end(self, context):
        super().end(context)
        if self._circle is not None:
            self._circle.remove()
        self._grip = self._circle = self._pressed = None

    def _drag(self, context, event, obj):
        self._mouse = Vector((event.mouse_region_x, event.mouse_region_y))
        if self._grip is None:
            if (self._mouse - self._start).length < context.preferences.inputs.drag_threshold_mouse:
                return
            if self._covered:
                raise SceneError(tool_choice.in_front(obj, self._covered))
            self._fit(context, obj)
            self._size_taken = self.size
            with pose_object_making.ready(obj) as (obj, self._made), kept.writing(obj):
                self._grip = Grip(obj, self.vertex, self.size, self.handle)
                self._drag(context, event, obj)
                engine.have_all("tick")  # so that Blender evaluates a large mesh once, with its first pose
            self.remember_object(obj)
            self._active = context.view_layer.objects.active.name if context.view_layer.objects.active else ""
            context.view_layer.objects.active = pose_objects.shown(obj)  # Properties and overlay show what is posed
            return
        self.offset = self._pressed.turn @ (self._on_plane(context, self._mouse) - self._on_plane(context, self._start))
        self._grip.move(obj, Vector(self.offset))

    def _fit(self, context, obj):
        """Takes the Size that the shape suggests, once, and not after the artist has turned the wheel."""
        if self._is_to_fit:
            self.size = tool_choice.size_at(context, obj, self._pressed)
            self._is_to_fit = False

    def _on_plane(self, context, mouse):
        """Where the mouse is in the world, in the plane of the view through the place that was pressed."""
        return view3d_utils.region_2d_to_location_3d(*tool_choice.find_view(context), mouse, self._pressed.place)

    def _resize(self, context, direction):
        if self._grip is not None and not self._grip.has_size:
            return
        self.size = min(MOST_SIZE, max(LEAST_SIZE, self.size * WHEEL_STEP**direction))
        self._is_to_fit = False
        if not self.handle and not self._fits and tool_choice.is_active(context):
            tool_choice.settings(context).size = self.size

    def _take_size(self, obj):
        if self._grip is not None and self.size != self._size_taken:
            self._size_taken = self.size
            if self._grip.resize(obj, self.size):
                engine.look_again(obj)

    def _let_go(self, context, obj):
        if self._grip is None:
            return self._click(context, obj)
        self._take_size(obj)
        handle = self._grip.handle(obj)
        if not self._grip.is_new and handle.size != self.size:
            self.properties.property_unset("size")  # or the last-operation panel would give it one
        _select_control(context, obj, self._grip)
        message, notes = _outcome(obj, self._grip, Vector(self.offset), self._made)
        if context.scene.tool_settings.use_keyframe_insert_auto:
            insert_keyframes(controls.mover(handle), notes)
        return self.tell(message, notes)

    def _click(self, context, obj):
        """Selects what is there, as Blender does: the control of a handle, or a mesh that was not the active one."""
        handle = obj.meanvalue.handles.get(self.handle)
        if handle is None and context.view_layer.objects.active == pose_objects.shown(obj):
            self.report({'INFO'}, "Press and drag to grab the mesh here; Shift-click pins it.")
            return {'CANCELLED'}
        if handle is not None:
            obj.meanvalue.active_handle = obj.meanvalue.handles.find(self.handle)
        if handle is not None and handle.follows == 'CONTROL':
            controls.select(handle)
            return self.tell("Control selected", [])
        subject.choose(obj)
        return self.tell(f"'{obj.name}' is the active object" if handle is None else f"'{handle.name}' is active", [])

    def _give_up(self, context):
        if self._grip is not None:
            obj = self.object()
            self._grip.take_back(obj)
            engine.look_again(obj)
            if self._made:
                pose_object_making.remove(obj)
            context.view_layer.objects.active = bpy.data.objects.get(self._active)
        return {'CANCELLED'}

    def _show(self, context, obj):
        has_size = self._grip is None or self._grip.has_size
        length = has_size * self.size * self._whole * max(map(abs, obj.matrix_world.to_scale()))
        self._circle.show(*tool_choice.find_view(context), self._mouse, self._pressed.place, length)
        live = engine.status(obj) if self._grip is not None else None
        size = f" Size {self.size:.0%} (Wheel)" if has_size else ""
        parts = [f"Grab:{size}", "R after release turns it", "Esc cancels"]
        parts += [live[0]] if live is not None and live[1] else []
        context.workspace.status_text_set("   ".join(parts))


def _select_control(context, obj, grip):
    """The control is selected, so that G, R and S move it; the mesh is the active object, and Properties show it."""
    handle = grip.handle(obj)
    if handle.control.name in context.view_layer.objects:
        controls.select(handle)
    context.view_layer.objects.active = pose_objects.shown(obj)


def _outcome(obj, grip, offset, made):
    """([message, details], [notes]). made: of ready()."""
    notes = list(grip.notes(obj))
    scene_input.model(obj).read(obj)
    known = scene_input.known(obj)
    notes += [] if known is None else known.notes
    if grip.is_new:
        message = "Handle made"
    elif grip.has_moved(obj, offset):
        message = "Handle moved"
    else:
        message = "The handle is where it was"
        if offset.length > 0.0:
            notes.append("Something else moves its control, such as a constraint or a driver: move that")
    live = engine.status(obj) or ("", False)
    notes += [live[0]] if live[1] else [] if known is None else grip.hold_back(obj, known)
    return [message, *made], notes
