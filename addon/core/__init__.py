# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays in, arrays and texts out. Nothing here knows Blender, so all of it runs under plain pytest."""
