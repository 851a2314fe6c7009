# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape of a mesh with other faces."""
