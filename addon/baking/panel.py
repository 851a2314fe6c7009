# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the sidebar about baking."""

import json

import bpy

from .. import wording
from ..errors import SceneError
from ..scene import subject
from ..scene.core import whole_files
from ..widgets.panels import PanelPart
from ..widgets.text_box import draw_wrapped
from .bridge import preparing
from .core import bake_times
from .core.point_cache import Header
from .operators.bake import MEANVALUE_OT_bake
from .operators.show_baked_frame import MEANVALUE_OT_show_baked_frame
from .operators.unbake import MEANVALUE_OT_unbake
from .properties import TO_CACHE


class MEANVALUE_PT_bake(PanelPart, bpy.types.Panel):
    """What becomes of the animation of the handles"""

    bl_label = "Bake"
    bl_options = {'DEFAULT_CLOSED'}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        obj = subject.of(context)
        settings = obj.meanvalue.bake
        layout.prop(settings, "target")
        _draw_range(layout, settings)
        if settings.target == TO_CACHE:
            _draw_cache(layout, obj, settings)
        else:
            _draw_keys(layout, settings)
        layout.prop(settings, "overwrite")
        _draw_size(layout, context, obj, settings)
        bake = layout.column()
        bake.scale_y = 1.4
        bake.operator(MEANVALUE_OT_bake.bl_idname, icon='REC')
        if obj.meanvalue.baked.target:
            draw_wrapped(layout, context, wording.sentence(obj.meanvalue.baked.note), icon='CHECKMARK')
            _draw_worst(layout, obj)
            layout.operator(MEANVALUE_OT_unbake.bl_idname, icon='X')


def _draw_worst(layout, obj):
    """Buttons to the frames with the highest energies."""
    frames = json.loads(obj.meanvalue.baked.worst or "[]")
    if not frames:
        return
    layout.label(text="Frames to look at:")
    row = layout.row(align=True)
    for frame in frames:
        row.operator(MEANVALUE_OT_show_baked_frame.bl_idname, text=bake_times.named(frame)).frame = frame


def _draw_range(layout, settings):
    layout.prop(settings, "frame_range")
    column = layout.column(align=True)
    if settings.frame_range == 'OWN':
        column.prop(settings, "frame_start")
        column.prop(settings, "frame_end")
    column.prop(settings, "step")
    column.prop(settings, "samples")


def _draw_cache(layout, obj, settings):
    layout.prop(settings, "path")
    if not settings.path:
        layout.label(text=preparing.default_path(obj), translate=False)
    layout.prop(settings, "use_part")
    if settings.use_part:
        column = layout.column(align=True)
        column.prop(settings, "part_start")
        column.prop(settings, "part_end")


def _draw_keys(layout, settings):
    layout.prop(settings, "prefix")
    layout.prop(settings, "keys")
    if settings.keys == 'EVERY':
        layout.prop(settings, "key_step")
    else:
        layout.prop(settings, "tolerance_kind")
        layout.prop(settings, "tolerance_share" if settings.tolerance_kind == 'SHARE' else "tolerance")
    layout.prop(settings, "use_absolute")


def _draw_size(layout, context, obj, settings):
    """How much there is to do, or why it cannot be done."""
    try:
        times = preparing.times_of(context.scene, settings)
    except SceneError as error:
        draw_wrapped(layout, context, wording.sentence(str(error)), icon='ERROR')
        return
    text = wording.counted(len(times), "frame" if settings.samples == 1 else "sample")
    if settings.target == TO_CACHE:
        text += f", {whole_files.in_bytes(Header(len(obj.data.vertices), 0.0, 1.0, len(times)).bytes)}"
    layout.label(text=text)


CLASSES = (MEANVALUE_PT_bake,)
