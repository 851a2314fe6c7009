# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixes of shapes that turn instead of shrinking: what is mixed, and the in-between keys that stand for it."""
