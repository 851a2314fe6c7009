# SPDX-License-Identifier: GPL-3.0-or-later
"""Mean-Value Deform: pose a mesh by a few anchor vertices, keeping its surface detail.

Nothing is imported here but what register() needs, so that `core/` can be used without Blender.
"""

import sys

# Blender loads this file alone anew after an update over a copy that was on; the rest, and what names it in here, would
# be the older version's. But for the compiled module: it cannot be loaded twice.
for _name in [name for name in sys.modules if name.startswith(f"{__name__}.")]:
    if not _name.startswith(f"{__name__}.lib"):
        del sys.modules[_name]
        globals().pop(_name.removeprefix(f"{__name__}."), None)

bl_info = {
    "name": "Mean-Value Deform",
    "author": "The Mean-Value Deform contributors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > Mean-Value",
    "description": "Pose a mesh by a few handles, keeping its surface detail",
    "category": "Mesh",
}


def register():
    from . import registration

    registration.register()


def unregister():
    from . import registration

    registration.unregister()
