# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking: animated handles become a point cache or shape keys. plan, solve chunk by chunk, put together, hand over."""
