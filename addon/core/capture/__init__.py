# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion capture without Blender: what files hold (`readers.read()` gives a `Take`), and what is made of it."""
