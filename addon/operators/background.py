# SPDX-License-Identifier: GPL-3.0-or-later
"""Base of the operators whose work may take long: progress, Esc, and an interface that goes on drawing."""

import time

import bpy

from .. import compat
from ..bridge import scene_input
from ..core import wording
from ..errors import MeanValueError, SceneError
from ..workers.job import Job
from .base import MeshOperator

#: How often a running job is looked at.
TICK_SECONDS = 0.05

#: Work that is done sooner is waited for: no progress bar flickers up, and the result is there at once.
PATIENCE_SECONDS = 0.15

#: What the artist may do meanwhile: look around.
VIEW_EVENTS = {
    'MIDDLEMOUSE', 'WHEELUPMOUSE', 'WHEELDOWNMOUSE', 'WHEELINMOUSE', 'WHEELOUTMOUSE', 'MOUSEMOVE',
    'INBETWEEN_MOUSEMOVE', 'TRACKPADPAN', 'TRACKPADZOOM', 'MOUSEROTATE', 'NDOF_MOTION',
}  # fmt: skip


#: Operators that show progress, to be ended when the add-on is disabled: Blender does not tell them.
_running = []


def end_all():
    for operator in list(_running):
        operator.cancel(bpy.context)


class BackgroundOperator(MeshOperator):
    """Mix-in: subclasses define prepare(obj) and finish(obj, prepared, outcome) in place of run(obj).

    prepare() reads the scene and returns an object with work(execution), which runs on a thread and must not touch
    Blender, and require_unchanged(obj), which raises if the scene is another by then. finish() writes the outcome and
    returns (message, [notes]). All raise MeanValueError before they have changed anything. Without a window, or called
    to execute, all is done before the operator returns.
    """

    #: Said in the status bar, with the solver's stage behind it.
    doing = ""

    _job = None
    _prepared = None
    _timer = None
    _object_name = ""
    _object_identity = None

    def run(self, obj):
        prepared = self.prepare(obj)
        return self.finish(obj, prepared, prepared.work(None))

    def invoke(self, context, _event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        obj = scene_input.subject(context)
        started = time.monotonic()
        try:
            self._prepared = self.prepare(obj)
            self._job = Job(self._prepared.work)
        except MeanValueError as error:
            return self.refuse(error)
        self._object_name = obj.name
        if self._job.wait(max(0.0, started + PATIENCE_SECONDS - time.monotonic())):
            return self._end(obj)
        self._object_identity = compat.session_key(obj)
        _running.append(self)
        manager = context.window_manager
        self._timer = manager.event_timer_add(TICK_SECONDS, window=context.window)
        manager.progress_begin(0.0, 1.0)
        manager.modal_handler_add(self)
        self._show_progress(context)
        return {'RUNNING_MODAL'}

    def modal(self, context, event):
        if event.type == 'ESC' and event.value == 'PRESS':
            self._job.cancel()
        if self._job.is_finished:
            self._stop_showing(context)
            return self._end(self._object_again(), meanwhile=True)
        if event.type == 'TIMER':
            self._show_progress(context)
        return {'PASS_THROUGH'} if event.type in VIEW_EVENTS or 'TIMER' in event.type else {'RUNNING_MODAL'}

    def cancel(self, context):
        """Blender ends the operator: another file is loaded, or it quits."""
        self._job.cancel()
        self._job.wait()
        self._stop_showing(context)

    def _object_again(self):
        """The object that was worked on, under its name, or None."""
        obj = bpy.data.objects.get(self._object_name)
        return obj if obj is not None and compat.session_key(obj) == self._object_identity else None

    def _end(self, obj, meanwhile=False):
        """meanwhile: Blender went on since the scene was read."""
        try:
            outcome = self._job.result()
            if obj is None:
                raise SceneError(f"'{self._object_name}' is gone, so its result is dropped")
            if meanwhile:
                self._prepared.require_unchanged(obj)
            message, warnings = self.finish(obj, self._prepared, outcome)
        except MeanValueError as error:
            return self.refuse(error)
        finally:
            self._job = self._prepared = None
        return self.tell(message, warnings)

    def _show_progress(self, context):
        stage, share = self._job.progress
        if self._job.is_cancelled:
            text = "Cancelling ..."
        else:
            text = f"{self.doing} '{self._object_name}': {wording.stage(stage)}, {share:.0%}    Esc: Cancel"
        context.window_manager.progress_update(share)
        context.workspace.status_text_set(text)

    def _stop_showing(self, context):
        _running.remove(self)
        manager = context.window_manager
        manager.event_timer_remove(self._timer)
        manager.progress_end()
        if context.workspace is not None:
            context.workspace.status_text_set(None)
