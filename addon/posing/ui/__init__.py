# SPDX-License-Identifier: GPL-3.0-or-later
"""What is hung into Blender's interface."""
