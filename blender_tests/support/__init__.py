# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, snapshots and steps that tests share."""
