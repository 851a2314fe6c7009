# SPDX-License-Identifier: GPL-3.0-or-later
"""Base of the operators whose work may take long: progress, Esc, and an interface that goes on drawing."""

import time

import bpy

from .. import wording
from ..errors import CancelledError, MeanValueError
from ..scene import subject
from ..solver.job import Job, result_of
from .base import MeshOperator, ModalOperator

#: How often a running job is looked at.
TICK_SECONDS = 0.05

#: How long the scene is read in one go, of every tick.
SLICE_SECONDS = 0.03

#: Work that is done sooner is waited for: no progress bar flickers up, and the result is there at once.
PATIENCE_SECONDS = 0.15

#: What the artist may do meanwhile: look around.
VIEW_EVENTS = {
    'MIDDLEMOUSE', 'WHEELUPMOUSE', 'WHEELDOWNMOUSE', 'WHEELINMOUSE', 'WHEELOUTMOUSE', 'MOUSEMOVE',
    'INBETWEEN_MOUSEMOVE', 'TRACKPADPAN', 'TRACKPADZOOM', 'MOUSEROTATE', 'NDOF_MOTION',
}  # fmt: skip


class BackgroundOperator(ModalOperator, MeshOperator):
    """Mix-in: subclasses define prepare(obj) and finish(obj, prepared, outcome) in place of run(obj).

    prepare() reads the scene and returns what has work(execution), the steps of a Job, which must not touch Blender,
    and require_unchanged(obj), which raises where the scene is another by then; or None where nothing is to be solved.
    finish() writes the outcome and returns (message, [notes]). All raise MeanValueError before they have changed
    anything. before() and after() are for what has to be done on the main thread before and after the job, in slices.
    Without a window, or called to execute, all is done before the operator returns.
    """

    #: Said in the status bar, with the stage behind it.
    doing = ""

    _job = _steps = _prepared = None
    _progress = ("", 0.0)

    def before(self, _prepared):
        """Generator of (stage, share that is done), after each bit of work. @throws MeanValueError."""
        return iter(())

    def after(self, _prepared):
        """As before()."""
        return iter(())

    def progress_text(self, stage, share):
        return f"{wording.stage(stage)}, {share:.0%}    Esc: Cancel"

    def job_progress(self):
        """(stage, share that is done) while the job runs."""
        return self._job.progress

    def stopped(self):
        """What is said when it was stopped."""
        return "Cancelled. Nothing was changed"

    def run(self, obj):
        self.remember_object(obj)
        try:
            return result_of(self._all_steps(), lambda _progress: self._job and self._job.wait())
        finally:
            self._let_go()

    def invoke(self, context, _event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        self.remember_object(subject.of(context))
        self._steps = self._all_steps()
        until = time.monotonic() + PATIENCE_SECONDS
        while time.monotonic() < until:
            ended = self._step()
            if ended is not None:
                self._let_go()
                return ended
            if self._job is not None:
                self._job.wait(max(0.0, until - time.monotonic()))
        context.window_manager.progress_begin(0.0, 1.0)
        self._show_progress(context)
        return self.begin(context, TICK_SECONDS)

    def react(self, context, event):
        """A job that is stopped ends when the solver has noticed."""
        if event.type == 'TIMER':
            ended = self._step()
            if ended is not None:
                return ended
            self._show_progress(context)
        elif event.type == 'ESC' and event.value == 'PRESS' and not event.is_repeat:  # held, it would press twice
            if self._job is None or self._job.is_finished:
                return self.refuse(CancelledError(self.stopped()))
            self._job.cancel()
        return {'PASS_THROUGH'} if event.type in VIEW_EVENTS or 'TIMER' in event.type else {'RUNNING_MODAL'}

    def end(self, context):
        super().end(context)
        context.window_manager.progress_end()
        self._let_go()

    def _let_go(self):
        """Of the arrays that are held."""
        if self._steps is not None:
            self._steps.close()
        if self._job is not None:
            self._job.drop()
        self._steps = self._job = self._prepared = None

    def _all_steps(self):
        """The whole work. Gives (name of the stage, share that is done) between steps. Returns as finish() does."""
        self._prepared = prepared = self.prepare(self.object())
        yield "reading the mesh", 1.0
        if prepared is None:
            return self.finish(self.object(), None, None)
        yield from _in_slices(self.before(prepared))
        self._job = Job(prepared.work)
        while not self._job.is_finished:
            yield self.job_progress()
        outcome = self._job.result()
        if self._job.is_cancelled:  # at the very moment when it was ready
            raise CancelledError(self.stopped())
        if self._timer is not None:  # Blender went on since the scene was read
            prepared.require_unchanged(self.object())
        yield from _in_slices(self.after(prepared))
        return self.finish(self.object(), prepared, outcome)

    def _step(self):
        """Returns what Blender wants to hear of an operator that has ended, None if there is more to do."""
        try:
            self._progress = next(self._steps)
            return None
        except StopIteration as end:
            return self.tell(*end.value)
        except MeanValueError as error:
            return self.refuse(error)

    def _show_progress(self, context):
        stage, share = self._progress
        if self._job is not None and self._job.is_cancelled:
            text = "Stopping ..."
        else:
            text = f"{self.doing} '{self._object_name}': {self.progress_text(stage, share)}"
        context.window_manager.progress_update(share)
        context.workspace.status_text_set(text)


def _in_slices(steps):
    """Goes on with a generator for about SLICE_SECONDS at a time, and yields what it has yielded last."""
    until = time.monotonic() + SLICE_SECONDS
    for progress in steps:
        if time.monotonic() >= until:
            yield progress
            until = time.monotonic() + SLICE_SECONDS
