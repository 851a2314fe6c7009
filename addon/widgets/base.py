# SPDX-License-Identifier: GPL-3.0-or-later
"""What all operators share: what they work on, when they are available, and how they report."""

import bpy

from .. import compat, wording
from ..errors import CancelledError, MeanValueError, SceneError
from ..scene import pose_object_making, subject, views


class Reporting:
    """Mix-in: how operators tell what they did, and why they did nothing. MEANVALUE_OT_grab is `meanvalue.grab`.

    What is not given has its default, not what it had in the last call, but for operators that have presets."""

    bl_options = {'REGISTER', 'UNDO'}

    def __init_subclass__(cls):
        super().__init_subclass__()
        cls.bl_idname = f"meanvalue.{cls.__name__.removeprefix('MEANVALUE_OT_')}"
        for name, option in cls.__annotations__.items() if 'PRESET' not in cls.bl_options else ():
            options = {*option.keywords.get("options", ()), 'SKIP_SAVE'}
            cls.__annotations__[name] = option.function(**{**option.keywords, "options": options})

    def refuse(self, error):
        self.report({'INFO' if isinstance(error, CancelledError) else 'ERROR'}, wording.sentence(str(error)))
        return {'CANCELLED'}

    def warn(self, error):
        """As refuse(), without Blender's popup under the mouse, which takes the next click."""
        self.report({'WARNING'}, wording.sentence(str(error)))
        return {'CANCELLED'}

    def tell(self, message, warnings):
        """message: a short sentence, or [the sentence, details ...]. Details and warnings are lines of the Info editor,
        and the sentence is the last, which the status bar shows."""
        views.note_window()
        first, *details = [message] if isinstance(message, str) else message
        for line, kind in (*((each, 'INFO') for each in details), *((each, 'WARNING') for each in warnings)):
            self.report({kind}, wording.sentence(line))
        more = f" ({wording.counted(len(warnings), 'warning')}: click to read)" if warnings else ""
        self.report({'WARNING' if warnings else 'INFO'}, wording.sentence(first + more))
        return {'FINISHED'}


#: Operators that go on, to be ended when the add-on is disabled: Blender does not tell them.
_running = []


def end_all():
    for operator in list(_running):
        operator.cancel(bpy.context)


class ModalOperator(Reporting):
    """Mix-in of operators that go on beside the interface. Subclasses define react(context, event) in place of modal(),
    and failed(error), what it returns where that raises a MeanValueError."""

    _timer = None
    _object_name, _object_identity = "", None

    def begin(self, context, tick_seconds=None):
        """What invoke() returns to go on. tick_seconds: between events of a timer; None for no timer."""
        if tick_seconds is not None:
            self._timer = context.window_manager.event_timer_add(tick_seconds, window=context.window)
        context.window_manager.modal_handler_add(self)
        _running.append(self)
        return {'RUNNING_MODAL'}

    def remember_object(self, obj):
        """What object() finds again: nothing of Blender's may be held from one event to the next."""
        self._object_name, self._object_identity = obj.name, compat.session_key(obj)

    def object(self):
        """The object that is worked on, under its name. @throws SceneError if it is gone."""
        obj = bpy.data.objects.get(self._object_name)
        if obj is None or compat.session_key(obj) != self._object_identity:
            raise SceneError(f"'{self._object_name}' is gone. What was begun on it is dropped")
        return obj

    def modal(self, context, event):
        result = {'CANCELLED'}  # by an error that nobody foresaw
        try:
            result = self.react(context, event)
        except MeanValueError as error:
            result = self.failed(error)
        finally:
            if result & {'CANCELLED', 'FINISHED'}:
                self.end(context)
        return result

    def failed(self, error):
        return self.refuse(error)

    def end(self, context):
        """However it ends. Blender keeps the operator: subclasses let go here of what they hold."""
        if self not in _running:
            return
        _running.remove(self)
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        if context.workspace is not None:
            context.workspace.status_text_set(None)

    def cancel(self, context):
        """Blender ends the operator: another file is loaded, or it quits."""
        self.end(context)


class MeshOperator(Reporting):
    """Mix-in for operators on the mesh that the artist works on, or on what else worked_on() finds. Subclasses define
    run(obj): it returns (message, [notes]), or raises MeanValueError before it has changed anything."""

    worked_on = staticmethod(subject.of)

    #: Operators that only edit the settings work in every mode.
    needs_object_mode = True

    #: Whether it can begin on a mesh of another file: a pose object is made then.
    begins = False

    #: What else may be in the way: functions of the object to why it is not available, or None.
    problems = ()

    #: Name of a property that makes another button of the operator, with its own description; or "".
    switch = ""

    @classmethod
    def description(cls, _context, properties):
        is_on = cls.switch and getattr(properties, cls.switch)
        return properties.bl_rna.properties[cls.switch].description if is_on else ""  # then Blender shows that of cls

    @classmethod
    def poll(cls, context):
        problem = cls.problem(cls.worked_on(context))
        if problem:
            cls.poll_message_set(wording.sentence(problem))
        return problem is None

    @classmethod
    def problem(cls, obj):
        """Why the operator is not available for `obj`, or None."""
        problem = (subject.problem_to_begin if cls.begins else subject.object_problem)(obj)
        if problem is None and cls.needs_object_mode:
            problem = subject.mode_problem(obj)
        for find in cls.problems:
            problem = problem or find(obj)
        return problem

    def execute(self, context):
        try:
            with pose_object_making.ready(self.worked_on(context)) as (obj, made):
                message, warnings = self.run(obj)
        except MeanValueError as error:
            return self.refuse(error)
        return self.tell([message, *made] if made else message, warnings)
