# SPDX-License-Identifier: GPL-3.0-or-later
"""Work beside the interface: arrays in, arrays out, progress and cancel."""
