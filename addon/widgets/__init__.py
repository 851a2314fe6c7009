# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators, panels and overlays are made of."""
