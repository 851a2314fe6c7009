# SPDX-License-Identifier: GPL-3.0-or-later
"""What `./dev demo` runs inside Blender: models, poses by the add-on's operators, renders, report.

The modelling files (quad_mesh, tentacle, creature) need numpy only, so tests and
benchmarks outside Blender use the same shapes.
"""


class DemoError(Exception):
    """Something that the user can put right: its message says how, and no traceback is shown."""
