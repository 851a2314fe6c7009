# SPDX-License-Identifier: GPL-3.0-or-later
"""The printed report, also written as report.txt. No bpy."""


def block(title, rows):
    """Lines of a subject from its rows (label, value)."""
    return [title, *(f"  {label + ':':<27}{value}" for label, value in rows), ""]


def text(about, blender_version, addon_version, blocks):
    """The whole report from the lines of each subject. about: what is shown, and lines that explain the figures."""
    head = [f"Mean-Value Deform {addon_version}, Blender {blender_version}: {about[0]}", *about[1:], ""]
    return "\n".join(head + [line for block in blocks for line in block])
