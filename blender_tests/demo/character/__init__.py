# SPDX-License-Identifier: GPL-3.0-or-later
"""A clothed figure on a rig, posed by handles."""
