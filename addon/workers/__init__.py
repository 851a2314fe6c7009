# SPDX-License-Identifier: GPL-3.0-or-later
"""Work beside Blender's main thread: arrays in, arrays out, progress and cancel."""
