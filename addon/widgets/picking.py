# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that have the artist click at meshes."""

import bpy

from .. import wording
from ..errors import MeanValueError, SceneError
from ..scene import subject, views
from . import under_mouse
from .background import VIEW_EVENTS
from .base import MeshOperator, ModalOperator


class PickingOperator(ModalOperator, MeshOperator):
    """Mix-in: what run(obj) works with is clicked, unless a script gives it.

    Subclasses define is_given(), whether nothing is to be clicked; prompt(obj), what the status bar asks for; and
    click(obj, view), of what under_mouse.view_under() found, which returns whether run() has all it needs. All raise
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

    def modal(self, context, event):
        looks_around = event.type in VIEW_EVENTS or (event.alt and event.type in {'LEFTMOUSE', 'RIGHTMOUSE'})
        if event.value != 'PRESS' or looks_around:
            return {'PASS_THROUGH'} if looks_around else {'RUNNING_MODAL'}
        if event.type in {'ESC', 'RIGHTMOUSE', 'RET', 'NUMPAD_ENTER'}:
            self.end(context)
            return {'FINISHED'} if self._has_run else {'CANCELLED'}
        if event.type not in {'LEFTMOUSE', 'BACK_SPACE'}:
            return {'RUNNING_MODAL'}
        obj = subject.of(context)
        if obj is None or obj.name != self._object_name:
            self.end(context)
            return self.refuse(SceneError("Another object is active now. Pick again"))
        try:
            if self._react(context, event, obj) and not self.repeats:
                self.end(context)
                return self.execute(context)
            context.workspace.status_text_set(self.prompt(obj))
        except MeanValueError as error:
            self.report({'WARNING'}, wording.sentence(str(error)))
        views.draw_again()
        return {'RUNNING_MODAL'}

    def _react(self, context, event, obj):
        """Whether a click was the last that is needed."""
        if event.type == 'BACK_SPACE':
            self._has_run |= self.take_back(obj)
            return False
        view = under_mouse.view_under(context, event)
        if view is None or not self.click(obj, view):
            return False
        if self.repeats:
            self.run(obj)
            self._has_run = True
        return True

    def end(self, context):
        super().end(context)
        if context.window is not None:
            context.window.cursor_modal_restore()
        views.draw_again('WINDOW')


def vertex_clicked(obj, view):
    """The vertex that was pressed. @throws SceneError beside the mesh."""
    return _required(under_mouse.press(obj, *view), obj).vertex


def place_clicked(obj, view):
    """Where the surface was pressed, (3,) in the object's own space. @throws SceneError beside the mesh."""
    return _required(under_mouse.place_under(obj, *view), obj)


def _required(found, obj):
    if found is None:
        raise SceneError(f"There is nothing of '{obj.name}' under the mouse. Click on its surface")
    return found


def require_vertex(obj, vertex):
    """@throws SceneError if the mesh has no vertex of that number."""
    count = len(obj.data.vertices)
    if not 0 <= vertex < count:
        raise SceneError(f"Vertex {vertex} is none of the {wording.vertices(count)} of '{obj.name}'")
