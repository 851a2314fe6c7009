# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the animation of the handles, or of the sliders of a rotation-aware mix."""

import json
import types

import bpy
from bpy.props import BoolProperty

from ... import wording
from ...errors import MeanValueError, SceneError
from ...live import engine
from ...mixing.bridge import mix_layers
from ...posing.bridge import scene_input
from ...scene import subject
from ...scene.core import whole_files
from ...widgets.background import BackgroundOperator
from .. import properties as bake_settings
from ..bridge import playing, preparing
from ..bridge.preparing import MixPreparation, Preparation
from ..core import bake_times

#: How long frames that are being solved are waited for when Blender loads another file or quits.
LEAVE_SECONDS = 1.0


class MEANVALUE_OT_bake(BackgroundOperator, bpy.types.Operator):
    bl_idname = "meanvalue.bake"
    bl_label = "Bake"
    bl_description = (
        "Solve every frame of the animated handles, or of the sliders of rotation-aware keys, and keep the "
        "result, as a point cache or as shape keys"
    )
    doing = "Baking"

    #: What is not given is taken from the object's settings.
    __annotations__ = {
        **bake_settings.options({'SKIP_SAVE'}),
        "confirm_size": BoolProperty(
            name="Confirm Size",
            description="Bake even if the result takes a lot of memory or room on the disk",
            options={'SKIP_SAVE'},
        ),
    }

    _prepared = None

    def invoke(self, context, event):
        obj = subject.of(context)
        options = self._options(obj)
        try:
            problem = preparing.size_problem(obj, preparing.times_of(context.scene, options), options)
        except MeanValueError as error:
            return self.refuse(error)
        if problem and not self.confirm_size and not bpy.app.background:
            self._ask(context, problem)
            return {'CANCELLED'}
        if context.screen is not None and context.screen.is_animation_playing:
            bpy.ops.screen.animation_cancel(restore_frame=False)  # it would take the frames away from under Bake
        return super().invoke(context, event)

    def start_reading(self, obj):
        return None if _is_mixed(obj) else scene_input.start_reading(obj)

    def prepare(self, obj, reading):
        kind = MixPreparation if _is_mixed(obj) else Preparation
        self._prepared = kind(obj, bpy.context.scene, self._options(obj), reading)
        return self._prepared

    def before(self, prepared):
        with engine.held():
            for share in prepared.sample(self._object):
                yield "sampling the animation", share

    def after(self, prepared):
        stage = "choosing the shape keys" if prepared.to_keys else "writing the point cache"
        for share in prepared.write(self._object()):
            yield stage, share

    def job_progress(self):
        baking = self._prepared.baking
        stage, _share = self._job.progress
        if baking.begun_at is None:
            return stage, 0.0
        left = baking.seconds_left
        remaining = "" if left is None else f", {wording.duration(left)} left"
        return f"frame {baking.frames_done:,} of {baking.total:,}{remaining}", baking.share

    def progress_text(self, stage, share):
        return f"{wording.stage(stage)}, {share:.0%}    Esc: Stop, and keep what is done"

    def ask_to_stop(self):
        self._prepared.baking.stop()

    def leave_job(self):
        baking = self._prepared.baking
        if baking is not None and baking.stop_before_leaving():
            self._job.wait(LEAVE_SECONDS)
        super().leave_job()

    def stopping_text(self):
        return "Stopping after the frames that are being solved ...    Esc: Stop at once, without them"

    def stopped(self):
        prepared = self._prepared
        return super().stopped() if prepared is None or prepared.baking is None else prepared.baking.stopped()

    def finish(self, obj, prepared, _outcome):
        if prepared.is_done and (prepared.to_keys or playing.is_in_place(obj, prepared.shown_path, prepared.plan)):
            return f"Nothing has changed since '{obj.name}' was baked, so there is nothing to do", []
        problem = playing.keys_problem(obj, prepared.options.use_absolute) if prepared.to_keys else None
        if problem:
            raise SceneError(problem)
        _require_few_keys(obj, prepared)
        if prepared.posing.binding is not None and prepared.posing.changes:
            prepared.posing.record(obj)
        if prepared.part is None or obj.meanvalue.baked.path != prepared.shown_path:
            playing.take_back(obj)
            notes = list(_play(obj, prepared))
        else:
            notes = []
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        warnings = [*prepared.notes, *notes]
        shared = subject.sharing_note(obj)
        if shared and prepared.to_keys:
            warnings.append(shared)
        if prepared.is_done:
            return f"The point cache '{prepared.shown_path}' was right still: '{obj.name}' plays it", warnings
        report = prepared.outcome[2] if prepared.to_keys else prepared.outcome
        obj.meanvalue.baked.worst = json.dumps([float(frame) for frame, _energy in report.worst()])
        return f"Baked '{obj.name}' to {_made(prepared)}: {report.text()}", [*report.notes(), *warnings]

    def _options(self, obj):
        """What is set of the operator's own properties, and else the object's settings."""
        settings = obj.meanvalue.bake
        values = {
            name: getattr(self if self.properties.is_property_set(name) else settings, name)
            for name in bake_settings.NAMES
        }
        return types.SimpleNamespace(**values, confirm_size=self.confirm_size)

    def _ask(self, context, problem):
        given = {name: getattr(self, name) for name in bake_settings.NAMES if self.properties.is_property_set(name)}

        def draw(menu, _context):
            menu.layout.label(text=wording.sentence(problem))
            menu.layout.operator_context = 'INVOKE_DEFAULT'
            again = menu.layout.operator(self.bl_idname, text="Bake All the Same", icon='CHECKMARK')
            for name, value in given.items():
                setattr(again, name, value)
            again.confirm_size = True

        context.window_manager.popup_menu(draw, title="Bake", icon='QUESTION')


def _is_mixed(obj):
    """Whether it is sliders that are baked, not handles."""
    return obj.meanvalue.mix.is_on or mix_layers.is_baked(obj)


def _play(obj, prepared):
    """Makes what plays the bake. Returns notes."""
    record = obj.meanvalue.baked
    if prepared.to_keys:
        kept, shapes, _report = prepared.outcome
        options = prepared.options
        yield from playing.play_keys(obj, prepared.plan, kept, shapes, options.prefix, options.use_absolute)
        record.key = prepared.keys_identity()
    else:
        yield from playing.play_cache(obj, prepared.shown_path, prepared.plan)
        record.key = prepared.plan.key
    first, last = (bake_times.named(prepared.times[row]) for row in (0, -1))
    record.note = f"Frames {first} to {last}, {_made(prepared)}"
    if prepared.to_keys:
        prepared.baking.store.remove()


def _made(prepared):
    if prepared.to_keys:
        return wording.counted(len(prepared.outcome[0]), "shape key")
    return f"'{prepared.shown_path}' ({whole_files.in_bytes(prepared.plan.header.bytes)})"


def _require_few_keys(obj, prepared):
    """Adaptive keys are known only now. @throws SceneError."""
    if not prepared.to_keys or prepared.options.confirm_size:
        return
    problem = bake_times.size_problem(len(prepared.times), len(obj.data.vertices), len(prepared.outcome[0]))
    if problem:
        raise SceneError(
            f"{problem}. Raise the tolerance, or bake with confirm_size=True: solved frames are kept, so it is quick"
        )
