# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the animation of the handles, or whatever else shapes the mesh (rooms.Bakeable), and takes that back."""

import bpy
from bpy.props import BoolProperty

from .. import wording
from ..errors import MeanValueError, require_none
from ..live import engine
from ..posing.bridge import scene_input
from ..posing.operators.pose import remove_what_was_made
from ..scene import baked, pose_object_making, subject, worn
from ..scene.baked import TO_CACHE, TO_KEYS
from ..widgets.background import BackgroundOperator
from ..widgets.base import MeshOperator
from . import properties
from .bridge import bones, playing, preparing
from .bridge.baking import Baking
from .core import bake_times


class MEANVALUE_OT_bake(BackgroundOperator, bpy.types.Operator):
    bl_label = "Bake"
    bl_description = "Solve every frame of the animated handles or sliders, into a point cache, keys or bones"
    doing = "Baking"
    problems = (
        lambda obj: bones.is_seen(obj)
        and obj.meanvalue.baked.target
        and f"'{obj.name}' is baked. Press Remove Bake first",
        lambda obj: None if baked.source(obj) or bones.is_seen(obj) else scene_input.unheld_problem(obj),
    )

    __annotations__ = {
        **properties.OPTIONS,
        "confirm": BoolProperty(
            name="Confirm",
            description="Bake even if the result is large, or replaces a file that is no earlier bake of this object",
        ),
    }

    def invoke(self, context, event):
        obj = subject.of(context)
        options = self._options(obj)
        try:
            times, path = preparing.times_of(context.scene, obj, options), preparing.paths(obj, options)[1]
            doubts = preparing.doubts(obj, times, options, path)
        except MeanValueError as error:
            return self.refuse(error)
        if doubts and not self.confirm and not bpy.app.background:
            given = {name: getattr(self, name) for name in properties.OPTIONS if self.properties.is_property_set(name)}

            def draw(menu, _context):
                for doubt in doubts:
                    menu.layout.label(text=wording.sentence(doubt))
                menu.layout.operator_context = 'INVOKE_DEFAULT'
                again = menu.layout.operator(self.bl_idname, text="Bake All the Same", icon='CHECKMARK')
                for name, value in given.items():
                    setattr(again, name, value)
                again.confirm = True

            context.window_manager.popup_menu(draw, title="Bake", icon='QUESTION')
            return {'CANCELLED'}
        if context.screen is not None and context.screen.is_animation_playing:
            bpy.ops.screen.animation_cancel(restore_frame=False)  # it would take the frames away from under Bake
        return super().invoke(context, event)

    def prepare(self, obj):
        return Baking(obj, bpy.context.scene, self._options(obj))

    def before(self, prepared):
        with engine.held():
            for share in prepared.sample(self.object):
                yield "sampling the animation", share

    def after(self, prepared):
        with engine.held():
            for share in prepared.write(self.object()):
                yield f"making the {prepared.options.target.lower().replace('_', ' ')}", share

    def job_progress(self):
        progress = self._prepared.progress()
        if progress is None:
            return self._job.progress[0], 0.0
        done, total, seconds_left = progress
        remaining = "" if seconds_left is None else f", {wording.duration(seconds_left)} left"
        return f"frame {done:,} of {total:,}{remaining}", done / total

    def progress_text(self, stage, share):
        return f"{wording.stage(stage)}, {share:.0%}    Esc: Stop, and keep what is done"

    def stopped(self):
        return (self._prepared and self._prepared.stopped()) or super().stopped()

    def finish(self, obj, prepared, _outcome):
        require_none(preparing.target_problem(obj, prepared.options))
        if prepared.posing is not None and prepared.posing.binding is not None:
            prepared.posing.record(obj)
        made, near, notes = prepared.play(obj)
        notes += subject.sharing_notes(obj) if prepared.options.target == TO_KEYS else []
        first, last = (wording.frame(prepared.times[row]) for row in (0, -1))
        obj.meanvalue.baked.note = f"Frames {first} to {last}, {made}"
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        if prepared.is_done:
            return f"'{obj.name}' is baked already, and nothing has changed since", notes
        if prepared.begun is not None:
            notes += bake_times.notes(prepared.times, prepared.begun.problems)
            if prepared.options.target != TO_CACHE:
                prepared.begun.remove()
        done = f"Baked {wording.counted(len(prepared.times), 'frame' if prepared.options.samples == 1 else 'sample')}"
        return f"{done} to {made}: {near}" if near else done, notes

    def _options(self, obj):
        options = properties.chosen(self, obj.meanvalue.bake, properties.OPTIONS)
        options.confirm = self.confirm
        return options


class MEANVALUE_OT_unbake(MeshOperator, bpy.types.Operator):
    """Take back what Bake made, so that the mesh follows its handles again"""

    bl_label = "Remove Bake"
    switch = "keep_bake"
    problems = (lambda obj: None if obj.meanvalue.baked.target else f"'{obj.name}' is not baked",)

    keep_bake: BoolProperty(
        name="Keep Bake, Remove Handles",
        description="The bake stays and plays without the add-on; handles, pins and what was made for them go",
    )

    def run(self, obj):
        along = [each for _, each in worn.listed(obj) if each.meanvalue.baked.target]
        for each in (obj, *along):
            if each == obj or not each.meanvalue.handles:  # what has handles has a bake of its own
                (playing.keep if self.keep_bake else playing.take_back)(each)
        if self.keep_bake:
            return f"The bake is kept. Removed: {remove_what_was_made(obj)}", []
        pose_object_making.take_over_rests()  # which waited for what played
        scene = bpy.context.scene
        scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        return "Removed the bake", []
