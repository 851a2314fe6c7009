# SPDX-License-Identifier: GPL-3.0-or-later
"""Drives Blender's real interface: display, process and listing outside of it, runner and driver inside."""
