# SPDX-License-Identifier: GPL-3.0-or-later
"""Two copies of the add-on, as when an extension is installed beside a legacy add-on: only the first that is on works.

Both would register the same classes and properties, and the second would take away those of the first.
"""

import bpy

#: A class that is registered as long as a copy is on.
MARK = "MEANVALUE_PT_panel"


def first_copy():
    """Package of another copy of this add-on that is on, or None."""
    mark = getattr(bpy.types, MARK, None)
    package = mark.__module__.removesuffix(".posing.ui.panel") if mark else __package__
    return None if package == __package__ else package


class MEANVALUE_AP_second_copy(bpy.types.AddonPreferences):  # noqa: N801  Blender's way
    bl_idname = __package__

    def draw(self, context):
        column = self.layout.column()
        for line in explanation(first_copy()):
            column.label(text=line, icon='ERROR')


def explanation(first):
    """Lines that say what keeps this copy from working and what to do; `first` as of first_copy()."""
    if first is None:
        return ("This copy is not on: untick it and tick it again",)
    return (f"Another copy is on ({first}), and this one does nothing", "Untick both, then tick the one to keep")


def register():
    bpy.utils.register_class(MEANVALUE_AP_second_copy)
    print("Mean-Value Deform:", ". ".join(explanation(first_copy())))


def unregister():
    bpy.utils.unregister_class(MEANVALUE_AP_second_copy)


def stands_back():
    """Whether this copy was enabled beside another and has registered nothing but its notice."""
    return MEANVALUE_AP_second_copy.is_registered
