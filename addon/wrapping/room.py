# SPDX-License-Identifier: GPL-3.0-or-later
"""What wrapping adds to Blender, for registration.py."""

from ..widgets import overlay
from . import panel
from .bridge import wrap_lines
from .operators import clear_wrap_pairs, pick_wrap_pairs, wrap
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

CLASSES = (
    pick_wrap_pairs.MEANVALUE_OT_pick_wrap_pairs,
    clear_wrap_pairs.MEANVALUE_OT_clear_wrap_pairs,
    wrap.MEANVALUE_OT_wrap,
    *panel.CLASSES,
)


def register():
    overlay.painters.append(wrap_lines.paint)


def unregister():
    overlay.painters.remove(wrap_lines.paint)
