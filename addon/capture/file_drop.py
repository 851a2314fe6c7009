# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion capture files that are dropped on a 3D View are imported, where Blender can do that (4.1 and later)."""

from .. import compat
from .core import readers
from .operators.import_motion import MEANVALUE_OT_import_motion

_FileHandler = compat.file_handler()

CLASSES = ()

if _FileHandler is not None:

    class MEANVALUE_FH_motion(_FileHandler):
        """Imports markers"""

        bl_idname = "MEANVALUE_FH_motion"
        bl_label = "Motion Capture"
        bl_import_operator = MEANVALUE_OT_import_motion.bl_idname
        bl_file_extensions = ";".join(readers.SUFFIXES)

        @classmethod
        def poll_drop(cls, context):
            return context.area is not None and context.area.type == 'VIEW_3D'

    CLASSES = (MEANVALUE_FH_motion,)
