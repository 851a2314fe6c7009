# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of the panel that says which objects go along."""

import bpy

from ... import wording
from ...scene import along, baked, subject, worn
from ...widgets.panels import draw_wrapped
from .panel import PosingPart


class MEANVALUE_UL_along(bpy.types.UIList):
    """One line for each object: whether it goes along, and how"""

    def draw_item(self, context, layout, _data, item, _icon, _active_data, _active_property, _index):
        alone, row = worn.problem(subject.of(context), item.object), layout.row(align=True)
        row.prop(item, "is_taken", text="")
        name = row.row()
        name.active = item.is_taken and not alone
        name.label(text=item.object.name, icon='ERROR' if alone else 'MESH_DATA', translate=False)
        row.prop(item, "kind", text="", emboss=False)

    def filter_items(self, context, data, collection):
        there = [other for _, other in worn.listed(subject.of(context))]
        return [self.bitflag_filter_item * (line.object in there) for line in getattr(data, collection)], []


class MEANVALUE_PT_along(PosingPart, bpy.types.Panel):
    """Which objects go along when the mesh is posed: clothes, hair, eyes"""

    bl_label = "Takes Along"

    @classmethod
    def poll(cls, context):
        is_alone = len(bpy.data.meshes) == 1  # the tab is long
        return super().poll(context) and not is_alone and worn.carrier(subject.of(context)) is None

    def draw_header_preset(self, context):
        count, alone = len(worn.taken(subject.of(context))), len(along.problems(subject.of(context)))
        text = f"{count} of {count + alone}" if alone else wording.counted(count, "object") if count else ""
        self.layout.label(text=text)

    def draw(self, context):
        layout, obj = self.layout, subject.of(context)
        settings, notes = obj.meanvalue, along.problems(obj)
        if settings.along:
            layout.label(text=f"Takes along {wording.counted(len(worn.taken(obj)), 'object')}")
            name, rows = MEANVALUE_UL_along.__name__, {"rows": 3, "maxrows": 6}
            layout.template_list(name, "", settings, "along", settings, "active_along", **rows)
            notes += [f"A mix of shape keys moves '{obj.name}' alone"] if baked.source(obj) else []
        layout.operator("meanvalue.find_along", text="Find", icon='VIEWZOOM')
        for text in notes:
            draw_wrapped(layout, context, wording.sentence(text), icon='INFO')
