# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of presets in the header of Solver."""

import pathlib

import bpy
from bl_ui.utils import PresetPanel

from .. import ids
from ..operators.add_preset import MEANVALUE_OT_add_preset

#: The presets that come with the add-on. They are read from where they are: nothing is copied to the user's own.
SHIPPED = pathlib.Path(__file__).resolve().parent.parent / "presets" / ids.PRESETS_FOLDER

_EXECUTE = "script.execute_preset"


class MEANVALUE_PT_presets(PresetPanel, bpy.types.Panel):
    """Ways of posing: method and rigidity"""

    bl_idname = ids.PRESETS_PANEL
    bl_label = "Presets"
    bl_space_type = 'VIEW_3D'
    preset_subdir = ids.PRESETS_FOLDER
    preset_operator = _EXECUTE
    preset_add_operator = MEANVALUE_OT_add_preset.bl_idname

    def draw(self, context):
        self.layout.emboss = 'PULLDOWN_MENU'
        self.layout.operator_context = 'EXEC_DEFAULT'
        self.path_menu([str(SHIPPED)], _EXECUTE, filter_ext=_is_preset, display_name=_title)
        nothing = [str(SHIPPED.parent)]  # a folder without presets: with none, Blender says that paths are missing
        self.path_menu(
            bpy.utils.preset_paths(self.preset_subdir) or nothing,
            _EXECUTE,
            filter_ext=_is_preset,
            display_name=_title,
            add_operator=self.preset_add_operator,
        )


def _is_preset(extension):
    return extension == ".py"


def _title(path):
    return bpy.path.display_name(path, title_case=False)
