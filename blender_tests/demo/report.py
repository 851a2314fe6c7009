# SPDX-License-Identifier: GPL-3.0-or-later
"""The printed report, also written as report.txt. No bpy."""


ABOUT = (
    "meshes posed by their anchors",
    "G is eq 15 of the paper, scaled to a rest bounding box of diagonal 1; the start is the rest shape with its",
    "anchors on their targets. The solver minimises G and the cost of lengths together.",
)


def subject_lines(title, figures, seconds, files):
    """Lines about one mesh.

    figures: pose.PoseFigures; seconds: {stage: seconds}; files: names relative to the output folder.
    """
    rows = [
        ("vertices, faces", f"{figures.vertex_count:,}, {figures.face_count:,}"),
        ("free vertices", f"{figures.free_count:,}"),
        ("anchors", f"{figures.anchor_count:,}"),
        ("energy G at the start", f"{figures.energy_before:.3e}"),
        ("energy G solved", f"{figures.energy_after:.3e}"),
        ("seconds", ", ".join(f"{stage} {value:.2f}" for stage, value in seconds.items())),
        ("files", ", ".join(files)),
    ]
    if figures.guarded_count:
        rows.insert(3, ("guarded vertices", f"{figures.guarded_count:,} encoded by a fallback rule"))
    return block(title, rows)


def block(title, rows):
    """Lines of a subject from its rows (label, value)."""
    return [title, *(f"  {label + ':':<27}{value}" for label, value in rows), ""]


def text(about, blender_version, addon_version, blocks):
    """The whole report from the lines of each subject. about: what is shown, and lines that explain the figures."""
    head = [f"Mean-Value Deform {addon_version}, Blender {blender_version}: {about[0]}", *about[1:], ""]
    return "\n".join(head + [line for block in blocks for line in block])
