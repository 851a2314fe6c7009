# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist shows what of the mesh belongs where on another one."""

import bpy

from ... import ids, wording
from ...errors import MeanValueError, SceneError
from ...scene import subject, views
from ...widgets import under_mouse
from ...widgets.background import VIEW_EVENTS
from ...widgets.base import MeshOperator
from ..bridge import wrap_lines, wrap_scene


class MEANVALUE_OT_pick_wrap_pairs(MeshOperator, bpy.types.Operator):
    bl_idname = "meanvalue.pick_wrap_pairs"
    bl_label = "Pick Pairs"
    bl_description = (
        "Click a point of the mesh, then the same point of the other one, and so on until Enter. Begin with the "
        "ends: head, hands, feet, finger tips"
    )

    target: bpy.props.StringProperty(
        name="Onto",
        description="The other object. Left empty: that of the pairs, else the other mesh that is selected",
        maxlen=ids.NAME_LENGTH,
        options={'SKIP_SAVE'},
    )
    vertex: bpy.props.IntProperty(
        name="Vertex", description="Vertex of the mesh; -1 to click", default=-1, min=-1, options={'SKIP_SAVE'}
    )
    place: bpy.props.FloatVectorProperty(
        name="Place", description="Where it belongs, in the other object's own space", size=3, options={'SKIP_SAVE'}
    )

    def invoke(self, context, _event):
        if self.vertex >= 0 or bpy.app.background or context.window is None:
            return self.execute(context)
        try:
            obj = subject.of(context)
            self.target = wrap_scene.target_of(context, obj, self.target).name
        except MeanValueError as error:
            return self.refuse(error)
        self._object_name, self._made = obj.name, 0
        context.window.cursor_modal_set('EYEDROPPER')
        self._tell_next(context)
        context.window_manager.modal_handler_add(self)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type in {'ESC', 'RIGHTMOUSE', 'RET', 'NUMPAD_ENTER'} and event.value == 'PRESS':
            return self._end(context)
        if event.type == 'LEFTMOUSE' and event.value == 'PRESS':
            obj, target = bpy.data.objects.get(self._object_name), bpy.data.objects.get(self.target)
            if obj is None or target is None or obj != subject.of(context):
                self._end(context)
                return self.refuse(SceneError("Another object is active now. Pick the pairs again"))
            found = under_mouse.view_under(context, event)
            if found is not None:
                try:
                    self._click(obj, target, found)
                except MeanValueError as error:  # said, and the artist clicks again
                    self.say('WARNING', wording.sentence(str(error)))
                    self.vertex = -1
                    wrap_lines.end()
                self._tell_next(context)
            return {'RUNNING_MODAL'}
        return {'PASS_THROUGH'} if event.type in VIEW_EVENTS else {'RUNNING_MODAL'}

    def cancel(self, context):
        self._end(context)

    def run(self, obj):
        target = wrap_scene.target_of(bpy.context, obj, self.target)
        pairs = obj.meanvalue.wrap.pairs
        count = len(obj.data.vertices)
        if not 0 <= self.vertex < count:
            raise SceneError(f"Vertex {self.vertex} is none of the {wording.vertices(count)} of '{obj.name}'")
        if any(pair.vertex == self.vertex for pair in pairs):
            raise SceneError(f"Vertex {self.vertex} has its place already. Choose another one, or clear the pairs")
        pair = pairs.add()
        pair.vertex, pair.place = self.vertex, self.place
        obj.meanvalue.wrap.target = target
        return f"Vertex {self.vertex} belongs there on '{target.name}': {wording.counted(len(pairs), 'pair')}", []

    def _click(self, obj, target, view):
        if self.vertex < 0:
            vertex = under_mouse.vertex_under(obj, *view)
            if vertex is None:
                raise SceneError(f"There is nothing of '{obj.name}' under the mouse. Click on its surface")
            self.vertex = vertex
            wrap_lines.begin(obj, vertex)
            return
        place = under_mouse.place_under(target, *view)
        if place is None:
            self.say('WARNING', f"There is nothing of '{target.name}' under the mouse. Click on its surface.")
            return
        self.place = place
        self.run(obj)
        self.vertex = -1
        wrap_lines.end()
        self._made += 1

    def _tell_next(self, context):
        where = self._object_name if self.vertex < 0 else self.target
        what = "a point" if self.vertex < 0 else "the same point"
        context.workspace.status_text_set(
            f"Click {what} of '{where}'    {wording.counted(self._made, 'pair')} picked    Enter: Done"
        )
        views.draw_again('WINDOW')

    def _end(self, context):
        wrap_lines.end()
        views.draw_again('WINDOW')
        if context.window is not None:
            context.window.cursor_modal_restore()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
        return {'FINISHED'} if self._made else {'CANCELLED'}
