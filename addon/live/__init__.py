# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that follow at once: what Blender tells, and when who is looked at."""
