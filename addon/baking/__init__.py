# SPDX-License-Identifier: GPL-3.0-or-later
"""Animated handles as point caches or shape keys."""
