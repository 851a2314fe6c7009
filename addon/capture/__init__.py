# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion capture markers move a mesh."""
