# SPDX-License-Identifier: GPL-3.0-or-later
"""Live posing: the mesh follows its controls."""
