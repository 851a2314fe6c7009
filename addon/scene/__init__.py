# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's objects and meshes as arrays, and what is known of them."""
