# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking adds to Blender, for registration.py."""

from . import panel
from .operators import bake, show_baked_frame, unbake
from .properties import PROPERTY_GROUPS, SETTINGS  # noqa: F401

CLASSES = (
    bake.MEANVALUE_OT_bake,
    show_baked_frame.MEANVALUE_OT_show_baked_frame,
    unbake.MEANVALUE_OT_unbake,
    *panel.CLASSES,
)


def register():
    pass


def unregister():
    pass
