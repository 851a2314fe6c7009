# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators, in files by what they are about."""
