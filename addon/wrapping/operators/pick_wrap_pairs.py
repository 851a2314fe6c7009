# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist shows what of the mesh belongs where on another one."""

import bpy

from ... import wording
from ...errors import MeanValueError, SceneError
from ...scene import subject, views
from ...widgets import under_mouse
from ...widgets.background import VIEW_EVENTS
from ...widgets.base import MeshOperator
from ..bridge import wrap_lines, wrap_scene

DESCRIPTION = (
    "Click a point of the mesh, then the same point of the other one, and so on until Enter; Backspace takes the last "
    "pair back. Begin with the ends: head, hands, feet, finger tips"
)


class MEANVALUE_OT_pick_wrap_pairs(MeshOperator, bpy.types.Operator):
    bl_idname = "meanvalue.pick_wrap_pairs"
    bl_label = "Pick Pairs"
    bl_options = {'UNDO'}  # adjusted afterwards, it would pick anew

    vertex: bpy.props.IntProperty(
        name="Vertex", description="Vertex of the mesh; -1 to click", default=-1, min=-1, options={'SKIP_SAVE'}
    )
    place: bpy.props.FloatVectorProperty(
        name="Place", description="Where it belongs, in the other object's own space", size=3, options={'SKIP_SAVE'}
    )
    clear: bpy.props.EnumProperty(
        name="Clear",
        description="Take picked pairs back in place of picking some",
        items=(
            ('NOTHING', "Nothing", "Pick pairs"),
            ('LAST', "Last", "Take the last pair back"),
            ('ALL', "All", "Take all pairs back"),
        ),
        options={'SKIP_SAVE'},
    )

    @classmethod
    def description(cls, _context, properties):
        return "Take all picked pairs back" if properties.clear == 'ALL' else DESCRIPTION

    @classmethod
    def problem(cls, obj):
        problem = super().problem(obj)
        if problem is None and not obj.meanvalue.wrap.pairs:  # else they may be cleared
            try:
                wrap_scene.target_of(bpy.context, obj)
            except SceneError as error:
                return str(error)
        return problem

    def invoke(self, context, _event):
        if self.clear != 'NOTHING' or self.vertex >= 0 or bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            obj = subject.of(context)
            self._target_name = wrap_scene.target_of(context, obj).name
        except MeanValueError as error:
            return self.refuse(error)
        self._object_name, self._has_changed = obj.name, False
        context.window.cursor_modal_set('EYEDROPPER')
        self._tell_next(context, obj)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        is_press = event.value == 'PRESS'
        if is_press and event.type in {'ESC', 'RIGHTMOUSE', 'RET', 'NUMPAD_ENTER'}:
            return self._end(context)
        if is_press and event.type in {'LEFTMOUSE', 'BACK_SPACE'}:
            obj, target = bpy.data.objects.get(self._object_name), bpy.data.objects.get(self._target_name)
            if obj is None or target is None or obj != subject.of(context):
                self._end(context)
                return self.refuse(SceneError("Another object is active now. Pick the pairs again"))
            try:
                if event.type == 'BACK_SPACE':
                    self._take_back(obj)
                else:
                    self._click(obj, target, under_mouse.view_under(context, event))
            except MeanValueError as error:  # said, and the artist clicks again
                self.report({'WARNING'}, wording.sentence(str(error)))
            self._tell_next(context, obj)
            return {'RUNNING_MODAL'}
        return {'PASS_THROUGH'} if event.type in VIEW_EVENTS else {'RUNNING_MODAL'}

    def cancel(self, context):
        self._end(context)

    def run(self, obj):
        pairs = obj.meanvalue.wrap.pairs
        if self.clear != 'NOTHING':
            return self._cleared(obj)
        target = wrap_scene.target_of(bpy.context, obj)
        count = len(obj.data.vertices)
        if not 0 <= self.vertex < count:
            raise SceneError(f"Vertex {self.vertex} is none of the {wording.vertices(count)} of '{obj.name}'")
        if any(pair.vertex == self.vertex for pair in pairs):
            raise SceneError(f"Vertex {self.vertex} has its place already. Choose another one, or clear the pairs")
        pair = pairs.add()
        pair.vertex, pair.place = self.vertex, self.place
        obj.meanvalue.wrap.target = target
        return f"Vertex {self.vertex} belongs there on '{target.name}': {wording.counted(len(pairs), 'pair')}", []

    def _cleared(self, obj):
        pairs = obj.meanvalue.wrap.pairs
        if not pairs:
            raise SceneError("No pairs are picked")
        if self.clear == 'LAST':
            pairs.remove(len(pairs) - 1)
        else:
            pairs.clear()
        return f"'{obj.name}' has {wording.counted(len(pairs), 'pair')} left", []

    def _click(self, obj, target, view):
        if view is None:
            return
        if self.vertex < 0:
            vertex = under_mouse.vertex_under(obj, *view)
            if vertex is None:
                raise SceneError(f"There is nothing of '{obj.name}' under the mouse. Click on its surface")
            self.vertex = vertex
            wrap_lines.begin(obj, vertex)
            return
        place = under_mouse.place_under(target, *view)
        if place is None:
            raise SceneError(f"There is nothing of '{target.name}' under the mouse. Click on its surface")
        self.place = place
        try:
            self.run(obj)
            self._has_changed = True
        finally:
            self._forget_vertex()

    def _take_back(self, obj):
        """The half of a pair that was clicked, else the last pair."""
        pairs = obj.meanvalue.wrap.pairs
        if self.vertex >= 0:
            self._forget_vertex()
        elif pairs:
            pairs.remove(len(pairs) - 1)
            self._has_changed = True

    def _forget_vertex(self):
        self.vertex = -1
        wrap_lines.end()

    def _tell_next(self, context, obj):
        where = self._object_name if self.vertex < 0 else self._target_name
        what = "a point" if self.vertex < 0 else "the same point"
        pairs = wording.counted(len(obj.meanvalue.wrap.pairs), "pair")
        context.workspace.status_text_set(
            f"Click {what} of '{where}'    {pairs} picked    Backspace: Take Back    Enter: Done"
        )
        views.draw_again()

    def _end(self, context):
        wrap_lines.end()
        views.draw_again('WINDOW')
        if context.window is not None:
            context.window.cursor_modal_restore()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        return {'FINISHED'} if self._has_changed else {'CANCELLED'}
