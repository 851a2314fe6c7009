# SPDX-License-Identifier: GPL-3.0-or-later
"""`./dev demo walk`: motion capture from the file to the film strip, by the add-on's operators.

subjects (what is captured and who is to move) -> capture (import, match, bake) -> measures, strip -> run (report).
The figure, its motions and its C3D files are generated.
"""
