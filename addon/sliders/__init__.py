# SPDX-License-Identifier: GPL-3.0-or-later
"""Shape keys that handles and markers drive."""
