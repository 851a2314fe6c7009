# SPDX-License-Identifier: GPL-3.0-or-later
"""Between Blender's data and numpy arrays, in bulk and one way at a time."""
